"""What a run shows step by step, for the report and the movie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from meshing.cells import CELLS
from meshing.paths import along_paths

from ..arrays import Array, Index, Mask
from ..elements.rotations import major_stress
from ..errors import SceneError
from ..model.mesh import CrackedMesh
from ..results.crushing import beside_loads
from ..results.fields import magnification
from .result import Result

#: values that are given for each crack cell
PROFILES = ("opening", "sliding", "traction_n", "traction_s", "damage")

#: points of the softening curve
_POINTS = 120


@dataclass(frozen=True)
class Views:
    """A run as it is drawn, frame by frame.

    Attributes
    ----------
    result : Result
    rows : (k,) rows of the history that are frames
    points : (n, 2) array, mm; of a solid body its front face
    polygons : corners of each element that is drawn, (m,) index arrays
    is_crack : (m,) array, whether it is a crack cell or an element of a band
    displacement : (k, n, 2) array, mm
    stress : (k, m) array, major stress, MPa
    distance : (c,) array, of the crack cells along the path, ascending, mm
    profiles : by name, (k, c) arrays; see `PROFILES`. Tractions beyond ft in compression beside a load are NaN
    softening : (w, stress), mm and MPa
    factor : by which displacements are enlarged
    """

    result: Result
    rows: Index
    points: Array
    polygons: list[Index]
    is_crack: Mask
    displacement: Array
    stress: Array
    distance: Array
    profiles: dict[str, Array]
    softening: tuple[Array, Array]
    factor: float

    @classmethod
    def from_result(cls, result: Result) -> Views:
        """The frames of a result; SceneError if it has none."""
        rows = result.frame_rows()
        if not rows:
            raise SceneError(
                f"{result.scene.title}: the run has no frames to show; expected output.frames above 0, as in "
                "--set output.frames=40"
            )
        frames, mesh = [result.frame(row) for row in rows], result.fields.mesh
        cells = _cells(mesh)
        used, polygons = _compact([corners for corners, _, _ in cells])
        number = np.array([at for _, at, _ in cells])
        stress = np.zeros((len(rows), sum(len(block.data) for block in mesh.whole.cells)))
        for own, frame in zip(stress, frames, strict=True):
            values = np.concatenate([major_stress(each) for each in frame.stress])
            own[: len(values)] = values
        distance, order, group, places = _along(mesh, result)
        displacement = np.array([frame.displacement[used, :2] for frame in frames])
        extent = float(np.ptp(mesh.points[:, :2], axis=0).max())
        each_cell = {name: np.array([frame.cracks[name][order] for frame in frames]) for name in PROFILES}
        profiles = {name: _means(values, group, len(distance)) for name, values in each_cell.items()}
        curve, material = result.scene.material.curve, result.scene.material
        end = float(curve.end)
        w = np.linspace(0.0, min(end, 5.0 * material.Gf / material.ft), _POINTS)
        # the traction under a load point has no limit: it says nothing of the crack
        pressed = (profiles["traction_n"] < -material.ft) & beside_loads(result, places)
        for name in ("traction_n", "traction_s"):
            profiles[name] = np.where(pressed, np.nan, profiles[name])
        return cls(
            result,
            np.array(rows),
            mesh.points[used, :2],
            polygons,
            np.array([kind for _, _, kind in cells]),
            displacement,
            stress[:, number],
            distance,
            profiles,
            (w, curve.stress(w)),
            magnification(extent, float(abs(displacement).max())),
        )

    def as_data(self) -> dict[str, Any]:
        """What the page of the report is given, as plain lists; numbers of four digits."""
        result, history = self.result, self.result.history
        energies = ("work", "elastic", "stored", "dissipated", "contact_work")
        return {
            "title": result.scene.title,
            "kind": result.scene.model.kind,
            "rows": self.rows.tolist(),
            "controlled": result.controlled,
            "x": _short(history[result.controlled]),
            "load": _short(history["load"]),
            "energies": {name: _short(history[name]) for name in energies},
            "measured": [dict(zip(("x", "low", "high"), map(_short, (m.x, *m.bounds)), strict=True)) for m in result.measured],
            "points": _short(self.points),
            "polygons": [corners.tolist() for corners in self.polygons],
            "crack": self.is_crack.astype(int).tolist(),
            "displacement": _short(self.displacement),
            "stress": _short(self.stress),
            "distance": _short(self.distance),
            "profiles": {name: _short(values) for name, values in self.profiles.items()},
            "softening": [_short(values) for values in self.softening],
            "factor": self.factor,
        }


def _short(values: Array) -> Any:
    """Nested lists with four digits, which keeps a page small."""
    if values.ndim > 1:
        return [_short(row) for row in values]
    return [float(f"{value:.4g}") if np.isfinite(value) else None for value in values.tolist()]


def _cells(mesh: CrackedMesh) -> list[tuple[Index, int, bool]]:
    """Corners, number and kind of the elements that are drawn: all in 2D, of a solid body the faces at its front."""
    drawn: list[tuple[Index, int, bool]] = []
    height = mesh.points[:, -1]  # of a solid body
    is_front = height > height.max() - 1e-9 * max(mesh.extent, 1.0)
    first = 0
    for number, block in enumerate(mesh.whole.cells):
        kind = CELLS[block.type]
        ring = kind.n_corners if kind.dimension == 2 else kind.facet_corners
        for face in kind.faces if kind.dimension == 3 else (tuple(range(ring)),):
            corners = block.data[:, list(face[:ring])]
            at = np.flatnonzero(is_front[corners].all(axis=1)) if kind.dimension == 3 else np.arange(len(corners))
            drawn += [(corners[i], first + int(i), number >= len(mesh.bulk)) for i in at]
        first += len(block.data)
    return drawn


def _compact(polygons: list[Index]) -> tuple[Index, list[Index]]:
    """The nodes that polygons use, and the polygons in their numbers."""
    ends = np.cumsum([len(corners) for corners in polygons])[:-1]
    used, flat = np.unique(np.concatenate(polygons), return_inverse=True)
    return used, np.split(flat, ends)


def _along(mesh: CrackedMesh, result: Result) -> tuple[Array, Index, Index, Array]:
    """Distances along the path, ascending; the crack cells in this order; to which distance each belongs, cells through the
    thickness sharing one; and the centre of a cell there."""
    cracks = mesh.whole.cells[len(mesh.bulk) :]
    centres = np.concatenate([mesh.points[block.data].mean(axis=1) for block in cracks])
    along = along_paths(centres[:, :2], result.scene.specimen.paths)
    order = np.argsort(along, kind="stable")
    extent = max(float(np.ptp(mesh.points[:, :2], axis=0).max()), 1e-300)
    is_new = np.diff(along[order], prepend=-np.inf) > 1e-6 * extent
    return along[order][is_new], order, np.cumsum(is_new) - 1, centres[order][is_new]


def _means(values: Array, group: Index, count: int) -> Array:
    """Means over the cells of each group, (k, count)."""
    size = np.bincount(group, minlength=count)
    return np.array([np.bincount(group, row, count) for row in values]) / size
