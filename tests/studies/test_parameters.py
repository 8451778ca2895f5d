"""Settings of a trade, and how they are carried to another scene."""

from __future__ import annotations

import pytest

from cohesive import Scene
from cohesive.law.widths import default_band_width, default_width
from cohesive.scenes.scene import built_in
from cohesive.studies.parameters import changes, label, problem, single

BEAM = Scene.load("notched-beam")
TWICE = BEAM.with_(**{f"specimen.{name}": 2.0 * getattr(BEAM.specimen, name)
                      for name in ("length", "span", "depth", "notch", "gauge")})  # fmt: skip


@pytest.mark.parametrize("model", ["discrete", "smeared"])
@pytest.mark.parametrize("name", built_in())
def test_a_scene_as_it_is_changes_nothing_and_every_setting_is_a_scene(name: str, model: str) -> None:
    where = "everywhere" if name == "single-crack-3d" else "path"  # which has no band along its crack
    scene = Scene.load(name).with_(**{"model.kind": model, "band.where": where})
    assert changes(scene, {}) == {} and changes(scene, {}, Scene(scene.data, scene.folder)) == {}
    for settings in [*single(scene), {"finer": 2.0}]:
        keys = changes(scene, settings)
        assert keys, label(settings)
        turned = scene.with_(**keys)
        assert changes(turned, settings, scene) == {}  # carried to where it is already, nothing is left to do
        if not {"model", "smoothing c_zn", "half"} & set(settings):
            assert problem(turned) == problem(scene)


def test_finer_is_finer_in_everything() -> None:
    assert changes(BEAM, {"finer": 4.0}) == {
        "mesh.crack_size": 0.3125, "mesh.far_size": 2.5, "interface.width": 0.015625, "stage.0.steps": 240, "solver.tol": 1e-7,
    }  # fmt: skip
    smeared = BEAM.with_(**{"model.kind": "smeared", "band.width": 2.0})
    assert changes(smeared, {"finer": 2.0})["band.width"] == 1.0
    jacobsen = Scene.load("jacobsen-mixed-mode")
    assert changes(jacobsen, {"steps": 2.0}) == {"stage.0.steps": 48, "stage.1.step": 0.005}


def test_sizes_follow_the_shorter_of_crack_and_process_zone() -> None:
    def sizes(scene: Scene) -> tuple[float, float]:
        turned = scene.with_(**changes(scene, {}, BEAM)).sizes
        assert turned is not None
        return turned.crack_size, turned.far_size

    coarse = {"mesh.crack_size": 5.0, "mesh.far_size": 20.0}  # which the user had
    assert sizes(TWICE.with_(**coarse)) == pytest.approx((1.25, 10.0))  # E Gf / ft^2 is the same
    tough = {"material.Gf": 4.0 * 0.07, "material.ft": 3.4}
    assert sizes(TWICE.with_(**coarse, **tough)) == pytest.approx((2.5, 20.0))  # the crack is twice as long
    assert sizes(TWICE.with_(**coarse, **{"material.Gf": 0.035})) == pytest.approx((0.625, 5.0))


def test_the_width_follows_its_own_rule() -> None:
    rule = default_width(50.0, TWICE.zone_length)
    assert "interface.width" not in changes(TWICE, {}, BEAM)  # which the scene has
    assert changes(TWICE, {"width": 2.0}, BEAM)["interface.width"] == 2.0 * rule
    assert changes(TWICE.with_(**{"interface.width": 3.0}), {}, BEAM)["interface.width"] == rule
    wide = BEAM.with_(**{"interface.width": 0.125})  # twice its rule
    assert changes(TWICE, {}, wide)["interface.width"] == pytest.approx(2.0 * rule)
    as_printed = TWICE.with_(**{"interface.width": "h"})  # eq. (21) is the user's model
    assert "interface.width" not in changes(as_printed, {"width": 2.0}, BEAM) and {"width": 2.0} not in single(as_printed)


def test_the_width_of_a_band_follows_its_own_rule() -> None:
    band = BEAM.with_(**{"model.kind": "smeared"})
    assert "band.width" not in changes(band, {"crack size": 2.0})
    assert changes(band, {"crack size": 2.0, "width": 4.0})["band.width"] == 4.0 * default_band_width(25.0, BEAM.zone_length)
    assert changes(band.with_(**{"band.width": 3.0}), {"crack size": 2.0}, band)["band.width"] == band.band_width
    everywhere = band.with_(**{"band.where": "everywhere"})
    assert "band.width" not in changes(everywhere, {"finer": 2.0}) and {"width": 2.0} not in single(everywhere)


def test_steps_keep_their_number_and_do_not_grow() -> None:
    def steps(**keys: object) -> int:
        scene = TWICE.with_(**{"stage.0.steps": 7}, **{key.replace("__", "."): value for key, value in keys.items()})
        return int(changes(scene, {"steps": 0.5}, BEAM)["stage.0.steps"])

    assert steps() == 30
    assert steps(stage__0__to=0.09) == 30
    assert steps(stage__0__to=0.36) == 60
    assert steps(stage__0__to=0.36, material__Gf=0.14) == 30  # openings scale with Gf / ft
    assert steps(stage__0__control="load", stage__0__to=5000.0) == 30
    assert steps(stage__0__to=[0.1, 0.0]) == 30
    there = BEAM.with_(stage=[{"control": "opening", "to": 0.18, "step": 0.003}])
    assert changes(there, {}, BEAM) == {}
    assert changes(there, {"steps": 0.5}, BEAM)["stage.0.step"] == pytest.approx(0.006)


def test_layers_and_shapes_of_solids() -> None:
    beam = Scene.load("notched-beam-3d")  # four layers
    assert changes(beam, {"layers": 0.5}) == {"mesh.layers": 2} and changes(beam, {"layers": 0.1}) == {"mesh.layers": 1}
    assert changes(beam, {"finer": 2.5})["mesh.layers"] == 10
    thick = beam.with_(**{"specimen.thickness": 100.0, "mesh.layers": 1})
    assert changes(thick, {}, beam) == {"mesh.layers": 8}  # as thick as there
    by_rule = beam.with_(**{"mesh.layers": None})  # 50 / 12 mm: four
    assert changes(by_rule, {"far size": 2.0}) == {"mesh.far_size": 24.0}  # they follow it
    assert changes(by_rule, {"layers": 2.0}) == {"mesh.layers": 8}
    penny = Scene.load("single-crack-3d")
    assert penny.sizes is not None
    assert not {"mesh.shape", "mesh.layers"} & set(changes(penny, {}, beam))  # of tetrahedra, not extruded
    assert not any({"shape", "layers", "model"} & set(settings) for settings in single(penny))
    assert {"order": 2} in single(penny) and {"order": 2} not in single(beam)  # hexahedra are of first order
    fine = beam.with_(**{"mesh.shape": "triangle", "mesh.order": 2})
    assert changes(beam, {}, fine) == {"mesh.order": 2, "mesh.shape": "triangle"}
    band = beam.with_(**{"model.kind": "smeared"})
    assert changes(band, {}, fine) == {"mesh.shape": "triangle"}  # a band in space is of first order


def test_half_a_body_only_where_there_is_one() -> None:
    assert changes(TWICE, {"half": True}, BEAM)["model.half"] is True
    assert "model.half" not in changes(TWICE.with_(**{"specimen.notch_position": 5.0}), {"half": True}, BEAM)
    assert "model.half" not in changes(TWICE.with_(**{"model.half": True}), {}, BEAM)  # the user's own half stays


def test_labels() -> None:
    assert label({}) == "as it is"
    settings = {"crack size": 0.5, "tolerance": 1e-3, "half": True, "shape": "quad"}
    assert label(settings) == "crack size x 0.5, tolerance 0.001, half, shape quad"
