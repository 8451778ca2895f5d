"""The report as one HTML file, and the movie."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from cohesive import Result, Scene, SceneError, run
from cohesive.commands.command_line import main
from cohesive.outcome.movie import write_movie
from cohesive.outcome.page import write_page
from cohesive.outcome.views import Views
from tests.builders import coarse_beam

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A beam in both models, and in 3D."""
    home = tmp_path_factory.mktemp("runs")
    frames = {"output.frames": 6, "mesh.crack_size": 2.5, "mesh.far_size": 12.0, "stage.0.steps": 12}
    for model in ("discrete", "smeared"):
        run(Scene.load("notched-beam").with_(**frames), model).save(home / model)
    run(coarse_beam("notched-beam-3d", "stress", output__frames=3)).save(home / "solid")
    return home


def data_of(path: Path) -> list[dict[str, object]]:
    """The data of a page."""
    text = path.read_text(encoding="utf-8")
    shown = re.search(r'<script id="data" type="application/json">(.*?)</script>', text, flags=re.DOTALL)
    assert shown is not None
    return list(json.loads(shown[1]))


def test_a_page_holds_the_run_and_asks_for_nothing(folder: Path) -> None:
    assert main(["report", str(folder / "discrete")]) == 0
    path = folder / "discrete" / "report.html"
    text = path.read_text(encoding="utf-8")
    assert not re.search(r"https?://|src=|@import|url\(", text)
    parser = HTMLParser()
    parser.feed(text)
    (data,) = data_of(path)
    history = np.genfromtxt(folder / "discrete" / "history.csv", delimiter=",", names=True)
    np.testing.assert_allclose(data["load"], history["load"], rtol=1e-3)  # four digits
    assert len(data["rows"]) == len(data["displacement"]) == len(data["profiles"]["opening"]) >= 6  # type: ignore[arg-type,index]
    assert path.stat().st_size < 6e6


def test_profiles_follow_the_path(folder: Path) -> None:
    """The notch mouth is the widest place of the crack, and the last point stands on the softening curve."""
    views = Views.from_result(Result.load(folder / "discrete"))
    assert np.all(np.diff(views.distance) > 0) and views.distance[0] < 2.5 < 22.5 < views.distance[-1] < 25.0
    last = views.profiles["opening"][-1]
    assert np.all(np.diff(last) < 0)
    w, stress = views.softening
    on_curve = np.interp(last[0], w, stress)
    assert views.profiles["traction_n"][-1][0] == pytest.approx(on_curve, rel=0.05)  # the cell's mean, over its opening


def test_the_traction_under_the_load_is_left_out(folder: Path) -> None:
    """It has no limit there, -20 ft on this mesh; elsewhere the path is drawn to its end."""
    views = Views.from_result(Result.load(folder / "discrete"))
    for traction in views.profiles["traction_n"]:
        pressed = np.isnan(traction)
        assert pressed.any() and not pressed[views.distance < 0.9 * views.distance[-1]].any()
        assert np.nanmin(traction) > -4.0 * views.result.scene.material.ft
    assert np.isfinite(views.profiles["opening"]).all()



def test_two_runs_stand_side_by_side(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "both.html"
    write_page([Views.from_result(Result.load(folder / name)) for name in ("discrete", "smeared")], path)
    assert [each["kind"] for each in data_of(path)] == ["discrete", "smeared"]
    assert main(["report", str(folder), "-o", str(path)]) == 0  # the folder of a comparison


def test_a_solid_body_shows_its_front_face(folder: Path) -> None:
    views = Views.from_result(Result.load(folder / "solid"))
    assert {len(corners) for corners in views.polygons} == {4} and views.points.shape[1] == 2
    assert len(views.distance) == 18  # cells through the thickness share a place


def test_without_frames_there_is_nothing_to_show(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(coarse_beam("notched-beam", "stress", output__frames=0, stage__0__steps=3)).save(tmp_path)
    for path in tmp_path.glob("frame_*"):
        path.unlink()
    assert main(["report", str(tmp_path)]) == 2
    assert "has no frames to show" in capsys.readouterr().err
    assert main(["report", str(tmp_path / "none")]) == 2


@pytest.mark.long
def test_movie(folder: Path, tmp_path: Path) -> None:
    views, drawn = Views.from_result(Result.load(folder / "solid")), []
    write_movie(views, tmp_path / "beam.gif", lambda: drawn.append(1))
    with Image.open(tmp_path / "beam.gif") as movie:
        assert movie.n_frames >= len(views.rows) == len(drawn)  # type: ignore[attr-defined]
    with pytest.raises(SceneError, match=r"expected a name that ends with \.gif or \.mp4"):
        write_movie(views, tmp_path / "beam.avi")


@pytest.mark.slow
def test_the_command_writes_a_movie(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "notched-beam", "--movie", "-o", str(tmp_path), "--set", "mesh.crack_size=2.5"]) == 0
    assert "movie.gif" in capsys.readouterr().out
    with Image.open(tmp_path / "movie.gif") as movie:
        assert movie.n_frames >= 40  # type: ignore[attr-defined]


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="no chromium or google-chrome on this machine")
@pytest.mark.parametrize("width", [390, 1400])
def test_the_slider_moves_all_views_in_a_browser(folder: Path, tmp_path: Path, width: int) -> None:
    """Two positions of the slider give two texts and two pictures; nothing is asked from the network."""
    page, shots, said = tmp_path / "page.html", [], []
    write_page([Views.from_result(Result.load(folder / "discrete"))], page)
    text = page.read_text(encoding="utf-8")
    for at in (0, 3):
        page.write_text(text.replace('min="0" value="0"', f'min="0" value="{at}"'), encoding="utf-8")
        common = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        shot = tmp_path / f"{at}.png"
        sized = [f"--window-size={width},1200", f"--screenshot={shot}", "--virtual-time-budget=2000"]
        subprocess.run([*common, *sized, page.as_uri()], check=True, capture_output=True, timeout=60)
        dom = subprocess.run([*common, "--dump-dom", page.as_uri()], check=True, capture_output=True, timeout=60, text=True)
        shown = re.search(r'<div id="said"[^>]*>(.*?)</div>', dom.stdout)
        assert shown is not None
        said.append(shown[1])
        shots.append(shot.read_bytes())
    assert said[0] != said[1] and said[1].startswith("step ")
    assert shots[0] != shots[1]


def test_a_title_cannot_leave_its_place_in_the_page(folder: Path, tmp_path: Path) -> None:
    result = Result.load(folder / "discrete")
    title = "<!--<script> </title></script> {{data}} {{title}} & &lt; \u2028 ]]>"
    result.scene = result.scene.with_(title=title)
    path = tmp_path / "report.html"
    write_page([Views.from_result(result)], path)
    (data,) = data_of(path)
    assert data["title"] == title
    text = path.read_text(encoding="utf-8")
    assert len(re.findall("<script", text)) == 2 and len(re.findall("</title", text)) == 1
    assert f"<h1>{html.escape(title)}</h1>" in text
    shown = text.partition('type="application/json">')[2].partition("</script>")[0]
    assert not re.search("[<&\u2028]", shown)
