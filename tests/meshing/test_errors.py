"""The key that an error names, and the table of the sizes."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import pytest

from meshing import MeshError, MeshSizes, Outline, mesh_band, mesh_polygon, read_band_mesh, read_mesh
from meshing.specimens.user_entries import pressures_of

_SQUARE = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]
_PATH = [[(2.0, 0.0), (2.0, 4.0)]]
_SIZES = MeshSizes(1.0, 1.0)


@pytest.mark.parametrize(
    ("key", "call"),
    [
        ("crack_size", lambda: MeshSizes(0.0, 1.0)),
        ("far_size", lambda: MeshSizes(2.0, 1.0)),
        ("shape", lambda: MeshSizes(1.0, 1.0, "hexagon")),
        ("order", lambda: MeshSizes(1.0, 1.0, order=3)),
        ("layers", lambda: MeshSizes(1.0, 1.0, layers=0)),
        ("mesh.crack_size", lambda: mesh_polygon(Outline(_SQUARE, _PATH), MeshSizes(1e-9, 1.0))),
        ("mesh.far_size", lambda: mesh_polygon(Outline(_SQUARE, [[(2.0, 0.0), (2.0, 1e-4)]]), MeshSizes(1e-5, 1e-4))),
        ("mesh.layers", lambda: mesh_polygon(Outline(_SQUARE, _PATH), MeshSizes(1.0, 1.0, layers=2))),
        ("load", lambda: mesh_polygon(Outline(_SQUARE, _PATH, nodes={"load": [(9.0, 9.0)]}), _SIZES)),
        ("band.width", lambda: mesh_band(Outline(_SQUARE, _PATH, nodes={"load": [(2.1, 2.0)]}), _SIZES, 1.0)),
        ("band.width", lambda: mesh_band(Outline(_SQUARE, _PATH), _SIZES, 0.0)),
        ("band.width", lambda: mesh_band(Outline(_SQUARE, _PATH), _SIZES, 5.0)),
        ("pressures", lambda: pressures_of([])),
        ("pressures", lambda: pressures_of("top")),
        ("file", lambda: read_mesh(Path("none.msh"), "crack")),
        ("file", lambda: read_band_mesh(Path("none.msh"), "band")),
        ("", lambda: mesh_polygon(Outline(_SQUARE, [[(2.0, 0.0)]]), _SIZES)),
        ("", lambda: mesh_polygon(Outline(_SQUARE, [[(2.0, 0.0), (2.0, 9.0)]]), _SIZES)),
    ],
)
def test_an_error_names_the_key_that_its_message_begins_with(key: str, call: Callable[[], object]) -> None:
    with pytest.raises(MeshError) as caught:
        call()
    assert caught.value.key == key
    assert str(caught.value).startswith(f"{key} = ") == bool(key)


def test_an_error_keeps_its_key_on_its_way_between_processes() -> None:
    error = pickle.loads(pickle.dumps(MeshError("mesh.order = 2: expected 1", "mesh.order")))
    assert (str(error), error.key) == ("mesh.order = 2: expected 1", "mesh.order")


def test_each_size_says_what_it_means() -> None:
    for field in fields(MeshSizes):
        assert field.metadata["meaning"]
    assert [f.name for f in fields(MeshSizes) if f.metadata["unit"] == "mm"] == ["crack_size", "far_size"]
