"""What does not fit together is refused in one line that names the key."""

from __future__ import annotations

from typing import Any

import pytest

from cohesive import Scene, SceneError, run
from cohesive.studies.accuracy import settings_for
from meshing import MeshError
from tests.builders import assert_refused, block


def smeared(**changes: Any) -> Scene:
    return block(model__kind="smeared", **changes)


def test_the_width_of_the_band_is_warned_of_and_refused() -> None:
    """ft^2 l / 2E over Gf: above 5 % a note, above 100 % no run."""
    limit = 2 * block().material.characteristic_length  # 820 mm
    tall = {"specimen__height": 2000.0, "specimen__width": 900.0, "mesh__far_size": 450.0, "mesh__crack_size": 450.0}
    first = [{"control": "driven", "to": 0.01, "steps": 1}]
    for part, noted in ((0.049, False), (0.051, True), (0.5, True)):
        result = run(smeared(band__width=part * limit, stage=first, **tall))
        assert any(f"{100 * part:.1f} % more than Gf" in note for note in result.notes) == noted
    with pytest.raises(ValueError, match=r"^band.width = 828.5\d+: .* 201 % of Gf .*expected less than 820.3 mm$"):
        run(smeared(band__width=1.01 * limit, stage=first, **tall))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"specimen.crack": [[0, 25], [0, 60]]}, r"^specimen: crack path of length 35 mm: 25 mm of it .* leaves at \(0, 50\)"),
        (
            {"specimen.crack": [[86, 0], [86, 50]], "band.width": 5.0},
            r"^band.width = 5: wider than the notch, or the edge, that the crack path ends on at \(86, 0\)",
        ),
        ({"specimen.notch_width": 2.0, "band.width": 5.0}, r"^band.width = 5: wider than the notch"),
        ({"band.width": 0.0}, r"^band.width = 0.0: expected a number above 0"),
        ({"band.where": "nowhere"}, r"^band.where = 'nowhere': expected"),
        ({"band.max_cracks": 4}, r"^band.max_cracks = 4: expected a number of at least 1 and at most 3"),
        ({"band.max_cracks": 2}, r"^band.max_cracks = 2: a plane on the path is the only one; expected band.planes = 'princ"),
        ({"band.threshold_angle": 30.0}, r"^band.threshold_angle = 30: a plane on the path is the only one"),
        ({"band.threshold_angle": 95.0}, r"^band.threshold_angle = 95.0: expected"),
        ({"model.half": True, "band.where": "everywhere"}, r"^model.half = true: cracks may form everywhere; expected false"),
        ({"stage.0.angle": 90.0}, r"^stage.0.angle = 90.0: this specimen is driven in one direction"),
        ({"specimen.gauge": 0.0, "band.where": "everywhere"}, r"^specimen.gauge: this band has no faces"),
        ({"stage.0.control": "dissipation", "stage.0.to": 500.0}, r"^stage.0.to = 500: the crack can dissipate"),
    ],
)
def test_what_does_not_fit_is_named_in_one_line(beam: Scene, changes: dict[str, Any], message: str) -> None:
    with pytest.raises((ValueError, MeshError), match=message) as caught:
        run(beam.with_(**{"model.kind": "smeared"}).with_(**changes))
    assert "\n" not in str(caught.value)


def test_a_band_has_no_width_of_its_own_where_its_elements_give_it() -> None:
    with pytest.raises(ValueError, match=r"band.width = 2: with band.where = 'everywhere' the elements give it"):
        block(band__width=2.0, band__where="everywhere")


def test_a_kind_without_a_gauge_names_the_band() -> None:
    panel = Scene.load("sandwich-panel").with_(**{"model.kind": "smeared", "band.where": "everywhere"})
    assert_refused(panel, r"^band.where = 'everywhere': this band has no faces .* expected 'path', or a kind with a gauge")


def test_what_has_no_meaning_in_3d_is_refused() -> None:
    single, extruded = Scene.load("single-crack-3d"), Scene.load("notched-beam-3d")
    for scene, changes, message in (
        (single, {"model.plane": "strain"}, r"^model.plane = 'strain': a single-crack-3d is no plane body"),
        (single, {"model.kind": "smeared"}, r"^band.where = 'path': there is no crack band"),
        (single, {"model.half": True}, r"^model.half = true"),
        (single, {"specimen.crack_radius": 30.0}, r"^specimen.crack_radius = 30.0: expected above 0 and below"),
        (extruded, {"mesh.layers": 0}, r"^mesh.layers = 0"),
        (extruded, {"model.kind": "smeared", "mesh.order": 2}, r"^mesh.order = 2: the elements of a crack band in three"),
        (extruded, {"specimen.tilt": 5.0}, r"^specimen.tilt: unknown key"),
    ):
        with pytest.raises(SceneError, match=message):
            scene.with_(**changes)
    assert_refused(single.with_(**{"mesh.layers": 3}), r"^mesh.layers = 3: this specimen is not extruded")
    assert_refused(single.with_(**{"mesh.shape": "quad"}), r"^mesh.shape = 'quad': this specimen is of tetrahedra")
    assert_refused(extruded.with_(**{"mesh.order": 2}), r"^mesh.order = 2: hexahedra are of first order")
    anywhere = single.with_(**{"model.kind": "smeared", "band.where": "everywhere"})
    assert_refused(anywhere, r"^specimen.gauge: this band has no faces")
    for scene, kind in (
        (extruded.with_(**{"model.kind": "smeared"}), "notched-beam in 3D, smeared, path"),
        (Scene.load("push-off-3d"), "push-off in 3D, discrete"),
    ):
        with pytest.raises(
            SceneError, match=f"^accuracy: no stored trade is of a {kind} model; `cohesive trade` measures one"
        ):
            settings_for(scene, "1%")


def test_default_sizes_follow_the_crack_surface() -> None:
    scene = Scene.load("single-crack-3d").with_(mesh={})
    assert scene.sizes is not None
    assert scene.sizes.crack_size == pytest.approx(scene.crack_area**0.5 / 12)
