"""The fields of a run as arrays: what is taken from its model and its states before they are let go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import meshio
import numpy as np

from ..arrays import Array, Index
from ..elements.bulk import ElasticBlock
from ..model.elements import Elements
from ..model.mesh import CrackedMesh

if TYPE_CHECKING:
    from ..model.model import Model
    from ..scenes.scene import Scene
    from ..solver.problem import State
    from .record import States

#: numbers, 4 MB, up to which displacements of more rows than those of the frames are held, and so are values at points with
#: cracks: a run of 1e5 unknowns that kept all of them would take longer, and its folder more room
MOST_NUMBERS = 500_000

#: part of the body's extent that the largest displacement is drawn as
_DRAWN = 0.06

#: rows that are recovered at once
_AT_ONCE = 32


@dataclass(frozen=True)
class Frame:
    """Fields of one step.

    Attributes
    ----------
    step : its number in the history
    row : of the history, by name
    displacement : (m, d), mm
    stress : for each elastic block, then for each block of a band, the mean stress of its cells, (n, k), MPa; components
        in the order of `elements.rotations.PAIRS`
    cracks : by name, one value for each crack cell or cell of the band: opening, sliding (mm), damage, traction_n,
        traction_s (MPa), planes. In a band the crack plane that is open widest counts; its opening and sliding are
        l_ch times the fracture strain, and strain_max is the major principal strain.
    """

    step: int
    row: dict[str, float]
    displacement: Array
    stress: list[Array]
    cracks: dict[str, Array]


@dataclass(frozen=True)
class Planes:
    """The damaged crack planes of a band in all rows of which the body is known, in one list; none for a discrete crack.

    Attributes
    ----------
    row, point : (c,) arrays, row of the history and point of each plane
    opening : (c,) array, jump along the normal, l_ch times the strain of the plane, mm
    normal : (c, d) array
    """

    row: Index
    point: Index
    opening: Array
    normal: Array

    @classmethod
    def from_states(cls, states: dict[int, State], model: Model) -> Planes:
        """From the states of some rows of a smeared run; none of any other."""
        own = {row: state.cracks.planes for row, state in states.items() if model.is_smeared}
        at, none = {}, np.zeros(0, dtype=np.int64)
        for row, each in own.items():  # undamaged a plane on the path is no crack yet
            left = model.cracks.point_law.strength_left(each)
            at[row] = np.flatnonzero(np.isfinite(left))
        return cls(
            np.concatenate([none, *(np.full(len(at[row]), row) for row in own)]),
            np.concatenate([none, *(each.point[at[row]] for row, each in own.items())]),
            np.concatenate([np.zeros(0), *(each.jump[at[row], 0] for row, each in own.items())]),
            np.concatenate([np.zeros((0, model.mesh.dimension)), *(each.rotation[at[row], 0] for row, each in own.items())]),
        )

    def of(self, row: int) -> Planes:
        """Those of one row."""
        at = self.row == row
        return Planes(self.row[at], self.point[at], self.opening[at], self.normal[at])


@dataclass(frozen=True)
class Fields:
    """The body of a run and its fields.

    Attributes
    ----------
    mesh : CrackedMesh
    bulk, band : the elastic elements, and those that may crack
    where, cell : (p, d) and (p,), position (mm) and cell of each point with cracks, the cells counted over all their blocks
    point_rows : (r,) rows of which the points are known, ascending
    points : by name, (r, p), see `Frame`
    rows : (f,) rows of which the whole body is known, all of them among `point_rows`
    displacement : (f, m, d), mm
    band_stress : (f, n, k), mean stress in the cells of a band, MPa; n is 0 without one
    planes : Planes
    """

    mesh: CrackedMesh
    bulk: list[ElasticBlock]
    band: list[ElasticBlock]
    where: Array
    cell: Index
    point_rows: Index
    points: dict[str, Array]
    rows: Index
    displacement: Array
    band_stress: Array
    planes: Planes

    @classmethod
    def from_run(cls, model: Model, states: States, needed: Sequence[int]) -> Fields:
        """From the states of a run.

        Parameters
        ----------
        needed : rows of which everything is wanted, among `states.kept`; of others as much as there is room for.
        """
        cracks, mesh, points = model.cracks, model.mesh, model.mesh.points
        rows = _held(states.kept, needed, points.size)
        values = {row: cracks.point_values(states[row]) for row in rows.tolist()}
        more = _held(states.kept, needed, len(cracks.cell) * max((len(each) for each in values.values()), default=1))
        values |= {row: cracks.point_values(states[row]) for row in more.tolist() if row not in values}
        point_rows = np.array(sorted(values), dtype=np.int64)
        whole = {row: states[row] for row in rows.tolist()}
        in_band = whole.values() if model.is_smeared else ()
        stress = [np.stack([_means(cracks.cell, each) for each in state.cracks.stress.T], axis=1) for state in in_band]
        return cls(
            mesh,
            model.bulk,
            model.band,
            cracks.where,
            cracks.cell,
            point_rows,
            {name: np.stack([values[row][name] for row in point_rows.tolist()]) for name in next(iter(values.values()), {})},
            rows,
            _displacements(model, list(whole.values())),
            np.stack(stress) if stress else np.zeros((len(rows), 0, 0)),
            Planes.from_states(whole, model),
        )

    def nearest(self, rows: Sequence[int]) -> list[int]:
        """The rows of which the body is known that are nearest to some rows."""
        return [int(self.rows[abs(self.rows - row).argmin()]) for row in rows]

    def frame(self, row: int, values: dict[str, float]) -> Frame:
        """The fields of a row of the history, whose columns are `values`.

        Raises
        ------
        LookupError
            If they were not kept.
        """
        at = _place(self.rows, row, "fields")
        displacement = self.displaced(row)
        ends = np.cumsum([len(block.cells) for block in self.band])[:-1]
        stress = [block.stress(displacement) for block in self.bulk]
        stress += np.split(self.band_stress[at], ends) if self.band else []
        return Frame(int(values["step"]), values, displacement, stress, self.cell_values(row))

    def displaced(self, row: int) -> Array:
        """Displacements of the nodes in a row, (m, d), mm; LookupError if they were not kept."""
        return np.asarray(self.displacement[_place(self.rows, row, "fields")])

    def cell_values(self, row: int) -> dict[str, Array]:
        """Means over the cells of the values at their points, see `Frame`; (n,) each.

        Raises
        ------
        LookupError
            If they were not kept.
        """
        return {name: _means(self.cell, values) for name, values in self.at_points(row).items()}

    def at_points(self, row: int) -> dict[str, Array]:
        """The values at the points with cracks in a row, see `Frame`; (p,) each.

        Raises
        ------
        LookupError
            If they were not kept.
        """
        at = _place(self.point_rows, row, "values on the crack")
        return {name: values[at] for name, values in self.points.items()}

    @property
    def locking(self) -> list[str]:
        """Kinds of elements of constant strain in a band, which lock."""
        return sorted({block.kind for block in self.band if block.element.has_constant_strain})

    def as_data(self) -> dict[str, Any]:
        """As lists, tables and arrays: all but the elements, which follow from the scene and the mesh."""
        own = ("where", "cell", "point_rows", "points", "rows", "displacement", "band_stress", "planes")
        mesh = self.mesh.whole
        return {name: getattr(self, name) for name in own} | {
            "mesh": {
                "points": mesh.points,
                "cells": [(block.type, block.data) for block in mesh.cells],
                "point_data": mesh.point_data,
                "cell_data": mesh.cell_data,
                "point_sets": mesh.point_sets,
                "cell_sets": mesh.cell_sets,
                "info": mesh.info,
            }
        }

    @classmethod
    def from_data(cls, scene: Scene, data: dict[str, Any]) -> Fields:
        """From what `as_data` gave, for the scene of the run."""
        mesh = CrackedMesh.from_mesh(meshio.Mesh(**data.pop("mesh")))
        elements = Elements.from_mesh(scene, mesh)
        return cls(mesh, elements.elastic, elements.cracking, **data)


def magnification(extent: float, largest: float) -> float:
    """By what displacements are enlarged in a picture, the largest one to a part of the body's extent: 1, 2 or 5 times a power
    of ten."""
    factor = _DRAWN * extent / max(largest, 1e-300)
    power = 10.0 ** np.floor(np.log10(factor))
    return float(power * max(digit for digit in (1.0, 2.0, 5.0) if digit * power <= factor * (1 + 1e-9)))


def _held(kept: Index, needed: Sequence[int], size: int) -> Index:
    """The rows that are held, of `size` numbers each: as many as there is room for, evenly spread, and those needed."""
    most = MOST_NUMBERS // max(size, 1)
    if len(kept) <= most:
        return kept
    spread = kept[np.linspace(0, len(kept) - 1, most).round().astype(int)] if most > len(needed) else []
    return np.union1d(np.array(needed, dtype=np.int64), np.array(spread, dtype=np.int64))


def _displacements(model: Model, states: list[State]) -> Array:
    """Displacements of all nodes, (f, m, d), mm."""
    parts = [
        model.condensation.recover(np.stack([state.v for state in states[first : first + _AT_ONCE]]))
        for first in range(0, len(states), _AT_ONCE)
    ]
    return np.concatenate(parts) if parts else np.zeros((0, *model.mesh.points.shape))


def _means(cell: Index, values: Array) -> Array:
    """Means over the cells of values at points, (p,)."""
    return np.asarray(np.bincount(cell, values) / np.bincount(cell))


def _place(rows: Index, row: int, what: str) -> int:
    at = int(np.searchsorted(rows, row))
    if at == len(rows) or rows[at] != row:
        raise LookupError(
            f"row {row}: its {what} were not kept, those of {len(rows)} rows were; expected one of these, as "
            "`result.frame_rows()` gives them, or a larger output.frames"
        )
    return at
