"""The page on which a scene's numbers are moved: what it is answered, by whom, and from where."""

from __future__ import annotations

import gc
import json
import re
import socket
import struct
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Scene, SceneError, fit, run
from cohesive.arrays import Array
from cohesive.commands.command_line import main
from cohesive.explore.explorer import Explorer
from cohesive.explore.server import ExploreServer
from cohesive.scenes.scene import dump_toml

#: a title that ends the data of a page, begins others, or is another part of it
HOSTILE = "<!--<script> </script> {{data}} {{title}} & &lt; \u2028 \u2029 ]]>"

QUICK = {"mesh.crack_size": 2.5, "mesh.far_size": 12.0, "stage.0.steps": 15}


@pytest.fixture(scope="module")
def explorer() -> Explorer:
    return Explorer(Scene.load("notched-beam").with_(**QUICK))


@pytest.fixture(scope="module")
def server(explorer: Explorer) -> Iterator[ExploreServer]:
    made = ExploreServer(explorer)
    thread = threading.Thread(target=made.serve_forever, daemon=True)
    thread.start()
    yield made
    made.shutdown()
    made.server_close()


def post(server: ExploreServer, what: str, **asked: Any) -> dict[str, Any]:
    request = urllib.request.Request(server.address + what, json.dumps(asked).encode())
    with urllib.request.urlopen(request, timeout=60) as answer:
        return dict(json.load(answer))


def test_an_answer_is_the_run(explorer: Explorer) -> None:
    answer = explorer.answer({"material.Gf": 0.1, "material.softening": "hordijk"})
    scene = Scene.load("notched-beam").with_(**QUICK)
    expected = run(scene.with_(**{"material.Gf": 0.1, "material.softening": "hordijk", "interface.width": 0.0625}))
    assert answer["error"] == ""
    np.testing.assert_allclose(answer["load"], expected.history["load"], rtol=1e-4)  # five digits
    assert len(answer["profiles"]["at the end"][0]) == len(answer["profiles"]["at the end"][1]) > 5


def test_a_notch_gets_a_mesh_of_its_own(explorer: Explorer) -> None:
    peaks = [max(explorer.answer({"specimen.notch": notch})["load"]) for notch in (10.0, 20.0)]
    assert peaks[0] > 1.3 * peaks[1]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"material.ft": -1.0}, "material.ft = -1.0: expected a number above 0"),
        ({"material.nu": 0.3}, "material.nu: not a control of this page"),
        ({"specimen.notch": 60.0}, "notch"),
    ],
)
def test_bad_numbers_are_answered_by_the_sentence_of_the_command(
    server: ExploreServer, changes: dict[str, float], message: str
) -> None:
    assert message in post(server, "run", changes=changes)["error"]
    assert post(server, "run", changes={})["error"] == ""  # the page is alive


def test_two_pages_do_not_disturb_each_other(server: ExploreServer) -> None:
    replies: dict[float, set[str]] = {0.05: set(), 0.15: set()}

    def move(Gf: float) -> None:
        for _ in range(4):
            replies[Gf].add(post(server, "run", changes={"material.Gf": Gf})["said"])

    threads = [threading.Thread(target=move, args=(Gf,)) for Gf in replies]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(replies[0.05]) == len(replies[0.15]) == 1 and replies[0.05] != replies[0.15]


def test_the_scene_is_given_back(server: ExploreServer, tmp_path: Any) -> None:
    changes = {"material.Gf": 0.1}
    (tmp_path / "scene.toml").write_text(post(server, "toml", changes=changes)["text"])
    assert Scene.load(tmp_path / "scene.toml").material.Gf == 0.1
    code = post(server, "python", changes=changes)["text"]
    names: dict[str, Any] = {}
    exec(code, names)
    assert names["result"].scene.material.Gf == 0.1


def table(history: dict[str, Array], x: str) -> str:
    """Load over a column as the text of a file."""
    rows = zip(history[x][1:].tolist(), history["load"][1:].tolist(), strict=True)
    return f"{x} (mm),load (N)\n" + "\n".join(f"{at!r},{load!r}" for at, load in rows)


def test_a_measured_file_is_drawn_and_fitted_as_the_command_does(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Load over cmod, on a beam whose opening is the mean jump over its crack: both print the same fit, to the last digit."""
    coarse = {"mesh.crack_size": 12.0, "mesh.far_size": 30.0, "stage.0.to": 0.6, "stage.0.steps": 16, "material.ft": 3.3}
    scene = Scene.load("en-14651").with_(**coarse)
    truth = run(scene.with_(**{"material.ft": 4.1, "material.Gf": 0.16})).history
    text = table(truth, "cmod")
    page = Explorer(scene)
    curve = page.measured(text, "beam.csv")
    assert curve["over"] == "cmod" and [each["name"] for each in curve["curves"]] == ["beam.csv"]
    np.testing.assert_allclose(curve["curves"][0]["low"], truth["load"][1:], rtol=1e-4)
    answer = page.answer({}, curve["over"])
    assert answer["over"] == "cmod" and " N at cmod " in answer["said"]

    fitted = page.fitted({}, text, "beam.csv")
    assert fitted["values"] == pytest.approx({"material.ft": 4.1, "material.Gf": 0.16}, rel=0.01)
    (tmp_path / "beam.csv").write_text(text)
    named = scene.with_(reference={"file": str(tmp_path / "beam.csv")})
    (tmp_path / "beam.toml").write_text(dump_toml(named.data))
    ends = {key: page.controls()[key] for key in fitted["values"]}
    vary = [word for key, each in ends.items() for word in ("--vary", f"{key}={each['low']!r}:{each['high']!r}")]
    assert main(["fit", str(tmp_path / "beam.toml"), "-o", str(tmp_path / "out"), *vary]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert fitted["summary"].splitlines() == printed[:-1]  # the last one names the folder
    assert any(line.split()[0] == "material.Gf" and " to " in line for line in printed)  # with its interval


def test_the_curve_of_the_scene_is_drawn_and_fitted(server: ExploreServer, explorer: Explorer) -> None:
    with urllib.request.urlopen(server.address, timeout=10) as answer:
        page = answer.read().decode()
    (facts,) = re.findall(r'<script id="data" type="application/json">(.*?)</script>', page)
    own = json.loads(facts)["measured"]
    assert own == explorer.measured() and own["over"] == "opening" and len(own["curves"][0]["x"]) == 13
    vary = {key: (explorer.controls()[key]["low"], explorer.controls()[key]["high"]) for key in ("material.ft", "material.Gf")}
    expected = fit(explorer.scene.with_(**{"material.ft": 3.0}), vary)
    replies = post(server, "fit", changes={"material.ft": 3.0})
    assert replies == {"values": expected.values, "summary": expected.summary()}


def test_a_scene_without_a_curve_has_none(beam: Scene) -> None:
    bare = Explorer(Scene({key: value for key, value in beam.data.items() if key != "reference"}))
    assert bare.measured() == {}
    assert "reference is missing" in bare.fitted({})["error"]


def test_files_that_are_no_curves_are_refused_by_their_name(server: ExploreServer) -> None:
    refused = post(server, "curve", text="hello", name="../notes.csv")["error"]
    assert "has no row with two numbers" in refused and "notes.csv" in refused and "/" not in refused
    flat = "opening (mm),load (N)\n0.01,0\n0.02,0\n0.05,0\n"
    assert "error" in post(server, "fit", changes={}, text=flat, name="flat.csv")


def test_only_the_token_on_this_machine_is_answered(server: ExploreServer) -> None:
    with urllib.request.urlopen(server.address, timeout=10) as answer:
        page = answer.read().decode()
    assert not re.search(r"https?://|src=", page) and "material.Gf" in page
    assert server.server_address[0] == "127.0.0.1"
    elsewhere = urllib.request.Request(server.address, headers={"Host": "example.org"})
    for asked in (server.address.replace(server.token, "token"), elsewhere, server.address + "etc"):
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(asked, timeout=10)
    assert post(server, "run", changes=3)["error"].startswith("the request cannot be read")


def test_a_scene_that_does_not_run_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explore", "notched-beam", "--set", "material.ft=-1"]) == 2
    assert "material.ft = -1" in capsys.readouterr().err
    with pytest.raises(SceneError):
        Scene.load("nowhere")


@pytest.mark.slow
def test_moves_take_no_memory(explorer: Explorer) -> None:
    import tracemalloc

    sizes = []
    tracemalloc.start()
    for i in range(120):
        explorer.answer({"material.Gf": 0.05 + 1e-4 * i})
        if i in (19, 119):
            gc.collect()  # what refers to itself is no leak
            sizes.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert sizes[1] < 1.05 * sizes[0] + 1e5


def said_to(server: ExploreServer, sent: bytes, leaves: bool = False) -> bytes:
    """What comes back for some bytes until the connection is closed."""
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=20) as connection:
        connection.sendall(sent.replace(b"TOKEN", server.token.encode()).replace(b"HOST", b"Host: 127.0.0.1"))
        if leaves:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # without a goodbye
            return b""
        answer = b""
        with suppress(ConnectionError):
            while part := connection.recv(65536):
                answer += part
    return answer


@pytest.mark.parametrize("length", ["abc", "-1", "1" * 400, "50000001", "1.5", "0x10", "+7"])
def test_a_length_that_is_none_is_refused(length: str, server: ExploreServer, capfd: pytest.CaptureFixture[str]) -> None:
    answer = said_to(server, f"POST /TOKEN/run HTTP/1.1\r\nHOST\r\nContent-Length: {length}\r\n\r\n{{}}".encode())
    assert answer.startswith(b"HTTP/1.0 404") and "Traceback" not in capfd.readouterr().err


@pytest.mark.parametrize(
    "body",
    [b"[" * 100_000, b'{"changes":' * 100_000, b"\xff\xfe{}", b"nul", b"3", b'{"changes": [1, 2]}', b"9" * 5000],
)
def test_a_body_that_is_none_is_answered(body: bytes, server: ExploreServer, capfd: pytest.CaptureFixture[str]) -> None:
    for action in (b"run", b"curve"):
        answer = said_to(
            server, b"POST /TOKEN/%s HTTP/1.1\r\nHOST\r\nContent-Length: %d\r\n\r\n" % (action, len(body)) + body
        )
        assert b"the request cannot be read" in answer
    assert "Traceback" not in capfd.readouterr().err


def test_a_name_that_no_file_has_is_answered(server: ExploreServer) -> None:
    for name in ("x" * 300, "x\0", "..", ""):
        assert post(server, "curve", changes={}, text="no curve", name=name)["error"]


def test_a_page_that_leaves_or_stalls_holds_nobody_up(
    server: ExploreServer, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    half = b"POST /TOKEN/run HTTP/1.1\r\nHOST\r\nContent-Length: 9\r\n\r\n{"
    for sent in (b"", b"GET /TOK", b"GET /TOKEN/ HTTP/1.1\r\nHOST\r\n\r\n", half):
        said_to(server, sent, leaves=True)
    monkeypatch.setattr(server.RequestHandlerClass, "timeout", 0.2)
    for sent in (b"", b"GET /TOK", half):
        assert said_to(server, sent) == b""
    assert "error" in post(server, "run", changes=3)
    assert "Traceback" not in capfd.readouterr().err


def test_a_title_cannot_leave_its_place_in_the_page(beam: Scene) -> None:
    made = ExploreServer(Explorer(beam.with_(title=HOSTILE)))
    threading.Thread(target=made.serve_forever, daemon=True).start()
    with urllib.request.urlopen(made.address, timeout=10) as answer:
        page = answer.read().decode()
    made.shutdown()
    made.server_close()
    shown = re.search(r'<script id="data" type="application/json">(.*?)</script>', page, flags=re.DOTALL)
    assert shown is not None and json.loads(shown[1])["title"] == HOSTILE
    assert not re.search("[<&\u2028]", shown[1])
