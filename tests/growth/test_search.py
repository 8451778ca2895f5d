"""Found paths: repeated, turned, mirrored, refused."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import meshio
import numpy as np
import pytest
import tomli_w

from cohesive import Scene, SceneError, run
from cohesive.commands.command_line import main
from cohesive.growth.crack import trial_lines
from cohesive.growth.path_trial import run_trial
from cohesive.growth.search import LARGEST_TURN, Search, find_path
from cohesive.model.build import build
from meshing.generation.outline import Outline
from meshing.generation.sizes import MeshSizes
from meshing.paths import Line, Point
from meshing.specimens import SPECIMENS, Drive, Gauge, NotchedBeam, Support
from tests.growth.beams import eccentric_beam, outlined_beam, turned

TURN = 37.0


@pytest.mark.long
def test_a_run_finds_its_path_and_repeats_without_the_search(tmp_path: Path) -> None:
    """The crack leans towards the load from notch to face, by the 24 to 34 degrees of published trials in its lower half;
    the saved scene gives the same history to the last digit."""
    result = run(eccentric_beam())
    line = result.path
    assert line[0].tolist() == [-50.0, 20.0]
    assert line[-1, 1] == pytest.approx(80.0, abs=1e-9)
    low = line[line[:, 1] < 50.0]
    assert math.degrees(math.atan2(*(low[-1] - low[0]))) == pytest.approx(29.0, abs=3.0)
    steps = np.diff(line, axis=0)
    turns = np.diff(np.arctan2(steps[:, 1], steps[:, 0]))
    assert abs(turns).max() <= LARGEST_TURN
    assert np.hypot(*steps.T).min() >= 4.0
    summary = result.summary()
    for words in (
        "segments of 8 mm from (-50, 20) to the face",
        "disagree by",
        "at the peak",
        "trials and",
        "passes in",
        "meshing",
    ):
        assert words in summary
    result.save(tmp_path)
    assert (tmp_path / "path.png").stat().st_size > 10_000
    with (tmp_path / "path.csv").open() as file:
        rows = list(csv.DictReader(file))
    np.testing.assert_allclose([[float(row["x"]), float(row["y"])] for row in rows], line, rtol=1e-8)
    again = run(Scene.load(tmp_path / "scene.toml"))
    assert again.found is None
    np.testing.assert_array_equal(again.path, line)
    assert again.peak_load == pytest.approx(result.peak_load, rel=1e-9)
    again.save(tmp_path)
    assert not (tmp_path / "path.png").exists()


def _turned_line(line: Line, degrees: float) -> Line:
    return [tuple(turned(p, degrees)) for p in line]  # type: ignore[misc]


@dataclass(frozen=True)
class TurnedBeam(NotchedBeam):
    """The beam on its own mesh, turned with all that acts on it; the path is rounded, for gmsh sees the last digit."""

    angle: ClassVar[float] = TURN

    @property
    def paths(self) -> list[Line]:
        return self.crack or [_turned_line(line, self.angle) for line in super().paths]

    @property
    def tips(self) -> list[Point]:
        return list(_turned_line(super().tips, self.angle))

    def outline(self, half: bool = False) -> Outline:
        upright = replace(self, crack=None)
        shape = NotchedBeam.outline(upright, half)
        return Outline(_turned_line(shape.corners, self.angle), [], [_turned_line(slit, self.angle) for slit in shape.slits])

    def mesh(self, sizes: MeshSizes, *, half: bool = False, dimension: int = 2) -> meshio.Mesh:
        keys = {name: getattr(self, name) for name in ("length", "span", "depth", "thickness", "notch", "notch_position")}
        upright = NotchedBeam(
            **keys,
            gauge=self.gauge,
            crack=[[(round(x, 9), round(y, 9)) for x, y in _turned_line(line, -self.angle)] for line in self.paths],
        )
        mesh = upright.mesh(sizes)
        mesh.points = np.array([turned(p, self.angle) for p in mesh.points])
        return mesh

    def held(self, *, half: bool = False) -> list[Support]:
        return [replace(each, direction=tuple(turned(each.direction, self.angle))) for each in super().held()]  # type: ignore[arg-type]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        return {
            name: replace(each, direction=tuple(turned(each.direction, self.angle))) for name, each in super().drives().items()
        }  # type: ignore[arg-type]

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        return {
            name: replace(each, direction=tuple(turned(each.direction, self.angle))) for name, each in super().gauges().items()
        }  # type: ignore[arg-type]

    def symmetry(self) -> None:
        return None


class UprightBeam(TurnedBeam):
    """The same, not turned."""

    angle = 0.0


@pytest.mark.long
def test_a_turned_mesh_gives_the_turned_path(monkeypatch: pytest.MonkeyPatch) -> None:
    """To 1e-6 of its length: all that differs is rounding, which Newton's method keeps within its tolerance."""
    monkeypatch.setitem(SPECIMENS, "turned-beam", TurnedBeam)
    monkeypatch.setitem(SPECIMENS, "upright-beam", UprightBeam)
    changes: dict[str, Any] = {"solver__tol": 1e-10, "grow__segment": 12.0}
    upright = find_path(eccentric_beam(specimen__kind="upright-beam", **changes)).lines[0]
    found = find_path(eccentric_beam(specimen__kind="turned-beam", **changes)).lines[0]
    np.testing.assert_allclose(_turned_line(found, -TURN), upright, atol=1e-6 * 70.0)


@pytest.mark.long
def test_another_mesh_of_the_turned_outline_moves_the_path_little() -> None:
    """Within a tenth of a segment, as far as the stresses tell a direction; two of the beam's meshes have other nodes."""
    upright, found = (find_path(outlined_beam(degrees)) for degrees in (0.0, TURN))
    judged = [v for v in upright.vertices if not v.fixed_direction]
    assert len(judged) >= 5
    for a, b in zip(judged[:5], _turned_line(found.lines[0], -TURN), strict=False):
        assert math.dist((a.x, a.y), b) < 0.8


@pytest.mark.slow
@pytest.mark.parametrize(("size", "segment"), [(1.0, 5.0), (1.0, 2.5), (0.5, 5.0), (2.0, 10.0)])
def test_mesh_and_segment_move_the_path_little(size: float, segment: float) -> None:
    """Less than 1.5 mm below mid-height of the ligament over factors of 4, against 1 mm and 4 mm."""
    sizes = {"mesh__far_size": 8.0, "stage__0__steps": 60}
    lines = [
        np.array(find_path(eccentric_beam(mesh__crack_size=a, grow__segment=b, **sizes)).lines[0])
        for a, b in ((size, segment), (1.0, 4.0))
    ]
    heights = np.linspace(20.0, 54.0, 18)
    one, other = (np.interp(heights, line[:, 1], line[:, 0]) for line in lines)
    assert abs(one - other).max() < 1.5


@pytest.mark.long
def test_two_notches_attract_each_other() -> None:
    """Both lean inwards alike, to a quarter of a segment: the mesh is not symmetric."""
    found = find_path(outlined_beam(notches=(-20.0, 20.0), stage__0__to=0.06, stage__0__steps=20))
    left, right = (np.array(line) for line in found.lines)
    assert np.interp(50.0, left[:, 1], left[:, 0]) > -17.0
    heights = np.linspace(20.0, 60.0, 9)
    np.testing.assert_allclose(
        np.interp(heights, left[:, 1], left[:, 0]), -np.interp(heights, right[:, 1], right[:, 0]), atol=2.0
    )


@pytest.mark.parametrize("scene", ["notched-beam", "notched-tension"])
def test_symmetric_specimens_crack_straight(scene: str) -> None:
    """Exactly, by the symmetry that the specimen knows of, and it is said."""
    straight = Scene.load(scene)
    found = find_path(straight.with_(**{"specimen.crack": "grow"}))
    assert found.lines == straight.specimen.paths
    assert found.notes == ["path: straight, the specimen is symmetric about it"]


@pytest.mark.long
def test_a_crack_starts_where_there_is_no_notch() -> None:
    """From the lower face below the load, upwards: within a tenth of an element of upright while it is judged."""
    scene = eccentric_beam(
        specimen__notch=0.0,
        specimen__notch_position=0.0,
        stage__0__to=0.03,
        stage__0__steps=10,
        grow__segment=16.0,
        grow__starts=[{"at": [0.0, 0.0], "direction": [0.0, 1.0]}],
    )
    line = find_path(scene).lines[0]
    assert line[0] == (0.0, 0.0)
    assert abs(np.array(line)[:4, 0]).max() < 1.0


@pytest.mark.slow
def test_no_sliding_leads_the_same_way() -> None:
    """Both criteria: within half a segment in the lower half; 2.6 mm on this coarse mesh, 1.3 mm on one half as coarse."""
    stress, symmetry = (np.array(find_path(eccentric_beam(grow__criterion=name)).lines[0]) for name in ("stress", "symmetry"))
    heights = np.linspace(20.0, 50.0, 7)
    np.testing.assert_allclose(*(np.interp(heights, line[:, 1], line[:, 0]) for line in (stress, symmetry)), atol=4.0)


def test_a_tip_that_is_not_seen_to_slide_follows_the_stress_and_is_named() -> None:
    class Blind(Search):
        def slide(self, *_: Any) -> float:
            return math.nan

    found = Blind(eccentric_beam(grow__criterion="symmetry", grow__segment=24.0)).find()
    assert any(note.startswith("warning: the path follows the stress at (-50, 20), ") for note in found.notes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"model.dimension": 3},
            r"^specimen.crack = 'grow': crack fronts are given, not found; expected grow.extrude = true, which finds the path",
        ),
        ({"model.half": True, "specimen.notch_position": 0.0}, r"^specimen.crack = 'grow': .* expected model.half = false$"),
        ({"grow.extrude": True}, r"^specimen.crack = 'grow': nothing is extruded in the plane; expected model.dimension = 3$"),
        ({"grow.criterion": "energy"}, r"^grow.criterion = 'energy': expected 'stress' or 'symmetry'$"),
        ({"grow.segment": 0.0}, r"^grow.segment = 0.0: expected a number above 0, in mm$"),
        ({"grow.starts": [{"at": [0, 0]}]}, r"^grow.starts = .*expected a list of \{at = \[x, y\], direction = \[x, y\]\}$"),
        ({"specimen.crack": [[-50, 20], [0, 80]]}, r"^grow: no path is looked for; expected specimen.crack = 'grow'"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        eccentric_beam().with_(**changes)


def test_what_only_the_search_sees_is_refused_too() -> None:
    with pytest.raises(SceneError, match=r"^grow.starts.0.at = \[0.0, 40.0\]: expected a point of a face or of a notch$"):
        find_path(eccentric_beam(grow__starts=[{"at": [0.0, 40.0], "direction": [0.0, 1.0]}]))
    with pytest.raises(SceneError, match=r"^specimen.crack = 'grow': no crack starts before the last stage ends"):
        find_path(eccentric_beam(stage=[{"control": "opening", "to": 1e-4, "steps": 2}]))
    with pytest.raises(SceneError, match=r"the path is not found yet; run\(scene\) finds it$"):
        build(eccentric_beam())


def test_a_drive_the_other_way_round_finds_the_same_path_and_says_so() -> None:
    beam = outlined_beam(grow__segment=16.0, stage__0__steps=10)
    turned_round = beam.with_(**{"specimen.drive.direction": [-c for c in beam.data["specimen"]["drive"]["direction"]]})
    pulled, pushed = run(beam), run(turned_round)
    np.testing.assert_allclose(pushed.path, pulled.path, atol=1e-9)
    assert pushed.history["load"].min() == pytest.approx(-pulled.peak_load)
    assert any(note.startswith("warning: no load is positive, they go down to -45") for note in pushed.notes)


def test_a_tip_is_critical_under_any_control_and_beside_a_weight() -> None:
    """Steps by dissipation come to the same state; a weight bends the beam as the load does, which it spares."""

    def load(**changes: Any) -> float:
        search = Search(eccentric_beam(stage__0__steps=80, **changes))
        (crack,) = search.starts
        lines = trial_lines([crack], search.body)
        trial = run_trial(search.scene, lines, [(crack.tip, crack.heading)], search.radius, LARGEST_TURN, True)
        assert trial.critical[0] is not None
        return trial.critical[0].load

    opened = load()
    assert load(stage__0__control="dissipation", stage__0__to=20.0) == pytest.approx(opened, rel=0.02)  # of other steps
    assert load(material__density=50 * 2400.0) < 0.95 * opened


@pytest.mark.long
def test_a_geo_file_grows_the_crack_of_its_corners(tmp_path: Path) -> None:
    """From the command line, to the last digit."""
    beam = outlined_beam(grow__segment=16.0, stage__0__steps=15)
    data = beam.data
    corners = data["specimen"].pop("corners")
    points = [f"Point({i}) = {{{x}, {y}, 0}};" for i, (x, y) in enumerate(corners, start=1)]
    lines = [f"Line({i}) = {{{i}, {i % 4 + 1}}};" for i in range(1, 5)]
    face = ["Curve Loop(1) = {1, 2, 3, 4};", "Plane Surface(1) = {1};"]
    (tmp_path / "beam.geo").write_text("\n".join([*points, *lines, *face]))
    data["specimen"]["file"] = "beam.geo"
    (tmp_path / "beam.toml").write_text(tomli_w.dumps(data))
    assert main(["run", str(tmp_path / "beam.toml"), "-o", str(tmp_path / "out")]) == 0
    found = Scene.load(tmp_path / "out" / "scene.toml").specimen.paths
    assert found == find_path(outlined_beam(grow__segment=16.0, stage__0__steps=15)).lines
