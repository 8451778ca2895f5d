"""What a run shows step by step, for the report and the movie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import meshio
import numpy as np

from meshing.cells import CELLS
from meshing.paths import along_paths

from ..arrays import Array, Index, Mask
from ..errors import SceneError
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
        """The frames of a result.

        Raises
        ------
        SceneError
            If it has none.
        """
        rows = result.frame_rows()
        if not rows:
            raise SceneError(
                f"{result.scene.title}: the run has no frames to show; expected output.frames above 0, as in "
                "--set output.frames=40"
            )
        frames = [result.frame_mesh(result.frame(row)) for row in rows]
        first = frames[0]
        cells = _cells(first)
        used, polygons = _compact([corners for corners, _, _ in cells])
        number = np.array([at for _, at, _ in cells])
        flat = {
            name: np.array([np.concatenate(frame.cell_data[name]) for frame in frames]) for name in ("stress_max", *PROFILES)
        }
        is_crack = np.concatenate(first.cell_data["is_crack"]) > 0
        distance, order, group, places = _along(first, np.flatnonzero(is_crack), result)
        displacement = np.array([frame.point_data["displacement"][used, :2] for frame in frames])
        extent = float(np.ptp(first.points[:, :2], axis=0).max())
        largest = float(abs(displacement).max())
        curve, material = result.scene.material.curve, result.scene.material
        end = float(curve.end)
        w = np.linspace(0.0, min(end, 5.0 * material.Gf / material.ft), _POINTS)
        profiles = {name: _means(flat[name][:, order], group, len(distance)) for name in PROFILES}
        # the traction under a load point has no limit: it says nothing of the crack
        pressed = (profiles["traction_n"] < -material.ft) & beside_loads(result, places)
        for name in ("traction_n", "traction_s"):
            profiles[name] = np.where(pressed, np.nan, profiles[name])
        return cls(
            result,
            np.array(rows),
            first.points[used, :2],
            polygons,
            np.array([kind for _, _, kind in cells]),
            displacement,
            flat["stress_max"][:, number],
            distance,
            profiles,
            (w, curve.stress(w)),
            magnification(extent, largest),
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


def _cells(mesh: meshio.Mesh) -> list[tuple[Index, int, bool]]:
    """Corners, number and kind of the elements that are drawn: all in 2D, of a solid body the faces at its front."""
    drawn: list[tuple[Index, int, bool]] = []
    crack = np.split(np.concatenate(mesh.cell_data["is_crack"]) > 0, np.cumsum([len(b.data) for b in mesh.cells])[:-1])
    front = mesh.points[:, 2].max()
    is_front = mesh.points[:, 2] > front - 1e-9 * max(np.ptp(mesh.points, axis=0).max(), 1.0)
    first = 0
    for block, is_crack in zip(mesh.cells, crack, strict=True):
        kind = CELLS[block.type]
        ring = kind.n_corners if kind.dimension == 2 else kind.facet_corners
        for face in kind.faces if kind.dimension == 3 else (tuple(range(ring)),):
            corners = block.data[:, list(face[:ring])]
            at = np.flatnonzero(is_front[corners].all(axis=1)) if kind.dimension == 3 else np.arange(len(corners))
            drawn += [(corners[i], first + int(i), bool(is_crack[i])) for i in at]
        first += len(block.data)
    return drawn


def _compact(polygons: list[Index]) -> tuple[Index, list[Index]]:
    """The nodes that polygons use, and the polygons in their numbers."""
    ends = np.cumsum([len(corners) for corners in polygons])[:-1]
    used, flat = np.unique(np.concatenate(polygons), return_inverse=True)
    return used, np.split(flat, ends)


def _along(mesh: meshio.Mesh, cracks: Index, result: Result) -> tuple[Array, Index, Index, Array]:
    """Distances along the path, ascending; the crack cells in this order; to which distance each belongs, cells through the
    thickness sharing one; and the centre of a cell there."""
    corners = [row for block in mesh.cells for row in block.data]
    centres = np.array([mesh.points[corners[i], : result.fields.mesh.points.shape[1]].mean(axis=0) for i in cracks])
    along = along_paths(centres[:, :2], result.scene.specimen.paths)
    order = np.argsort(along, kind="stable")
    extent = max(float(np.ptp(mesh.points[:, :2], axis=0).max()), 1e-300)
    is_new = np.diff(along[order], prepend=-np.inf) > 1e-6 * extent
    return along[order][is_new], cracks[order], np.cumsum(is_new) - 1, centres[order][is_new]


def _means(values: Array, group: Index, count: int) -> Array:
    """Means over the cells of each group, (k, count)."""
    size = np.bincount(group, minlength=count)
    return np.array([np.bincount(group, row, count) for row in values]) / size
