"""The fields of one step as a mesh that ParaView reads."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import meshio
import numpy as np

from ..arrays import Array
from ..elements.rotations import PAIRS, major_stress
from .fields import Fields, Frame


def frame_mesh(fields: Fields, frame: Frame, is_plane_strain: bool = False) -> meshio.Mesh:
    """Bulk and crack cells with the fields of a frame, in three dimensions; warp by `displacement` to see the crack open.

    `stress` is a tensor of nine components, row by row; across a plane body it is that of plane strain, or 0. The row of the
    history is field data."""
    mesh, n = fields.mesh.whole, sum(len(block.cells) for block in fields.bulk)
    m, d = mesh.points.shape
    points, displacement = (np.column_stack([x, np.zeros((m, 3 - d))]) for x in (mesh.points, frame.displacement))
    total = sum(len(block.data) for block in mesh.cells)
    # cells that a field does not belong to carry 0: NaN would break readers of the ASCII format
    flat = {name: np.r_[np.zeros(n), values] for name, values in frame.cracks.items()}
    flat["is_crack"] = np.r_[np.zeros(n), np.ones(total - n)]
    stress = np.concatenate(frame.stress)
    stress = np.concatenate([stress, np.zeros((total - len(stress), stress.shape[1]))])
    flat["stress"] = np.zeros((total, 9))
    for k, (i, j) in enumerate(PAIRS[d]):
        flat["stress"][:, [3 * i + j, 3 * j + i]] = stress[:, [k]]
    if is_plane_strain and d == 2:
        nu = np.concatenate([np.full(len(block.cells), _nu(block.D)) for block in (*fields.bulk, *fields.band)])
        flat["stress"][: len(nu), 8] = nu * stress[: len(nu), :2].sum(axis=1)
    flat["stress_max"] = major_stress(stress)
    ends = np.cumsum([len(block.data) for block in mesh.cells])[:-1]
    data = {name: np.split(values, ends) for name, values in flat.items()}
    facts = {name: np.array([value]) for name, value in frame.row.items()}
    return meshio.Mesh(points, [(b.type, b.data) for b in mesh.cells], {"displacement": displacement}, data, facts)


def _nu(D: Array) -> float:
    """Poisson's ratio of the elasticity of plane strain, in which D12 / D11 = nu / (1 - nu)."""
    ratio = float(D[0, 1] / D[0, 0])
    return ratio / (1.0 + ratio)


def write_frame(path: Path, mesh: meshio.Mesh) -> None:
    """Write a VTU file with field data, which meshio reads but does not write."""
    meshio.write(path, mesh, compression=None)  # compressing takes ten times as long as writing, for a third of the size
    kind = 'type="Float64" NumberOfTuples="1" format="ascii"'
    arrays = "".join(
        f"<DataArray {kind} Name={quoteattr(name)}>{float(values[0])!r}</DataArray>\n"
        for name, values in mesh.field_data.items()
    )
    text = path.read_bytes()
    at = text.index(b"<UnstructuredGrid>") + len(b"<UnstructuredGrid>")
    path.write_bytes(text[:at] + f"\n<FieldData>\n{arrays}</FieldData>".encode() + text[at:])
