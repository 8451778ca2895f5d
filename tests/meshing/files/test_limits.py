"""Files that say, or unpack to, more than a mesh: one sentence at once."""

from __future__ import annotations

import gzip
import lzma
import os
import struct
import time
import zlib
from base64 import b64encode
from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import pytest

from meshing import MeshError
from meshing.files.reading import load
from tests.builders import grid

N = 4_000_000_000
PIECE = bytes(1_000_000)


def bomb(path: Path, compressor: str, packed: bytes, encoding: str, blocks: int = 4000) -> None:
    """4 GB of zeros as the points of a .vtu file, in blocks of a megabyte."""
    head = struct.pack(f"<{3 + blocks}I", blocks, len(PIECE), len(PIECE), *[len(packed)] * blocks)
    body = packed * blocks
    text = b64encode(head) + b64encode(body)
    where = 'format="binary">' if encoding == "inline" else 'format="appended" offset="0">'
    points = f'<DataArray type="Float64" Name="Points" NumberOfComponents="3" {where}'.encode()
    points += (text if encoding == "inline" else b"") + b"</DataArray>"
    appended = b'<AppendedData encoding="%s">_' % encoding.encode() + (text if encoding == "base64" else head + body)
    appended = b"" if encoding == "inline" else appended + b"\n</AppendedData>"
    path.write_bytes(
        f'<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian" compressor="{compressor}">'
        f'<UnstructuredGrid><Piece NumberOfPoints="{len(PIECE) * blocks // 24}" NumberOfCells="0"><Points>'.encode()
        + points
        + b"</Points><Cells></Cells></Piece></UnstructuredGrid>"
        + appended
        + b"</VTKFile>"
    )


def assert_refused(path: Path, message: str) -> None:
    """In a sentence, and in less than 5 s of CPU."""
    clock = time.process_time()
    with pytest.raises(MeshError, match=message) as caught:
        load(path)
    assert time.process_time() - clock < 5.0
    assert str(caught.value).startswith("file = '") and "\n" not in str(caught.value)


@pytest.mark.parametrize("encoding", ["inline", "base64", "raw"])
@pytest.mark.parametrize(
    ("compressor", "pack"), [("vtkZLibDataCompressor", zlib.compress), ("vtkLZMADataCompressor", lzma.compress)]
)
def test_a_file_that_unpacks_to_gigabytes_is_refused(
    compressor: str, pack: Callable[[bytes], bytes], encoding: str, tmp_path: Path
) -> None:
    path = tmp_path / "bomb.vtu"
    bomb(path, compressor, pack(PIECE), encoding)
    assert path.stat().st_size < 7e6
    assert_refused(path, r"it unpacks to more than 250 MB")


@pytest.mark.parametrize("compression", ["zlib", "lzma", None])
def test_packed_files_are_read(compression: str | None, tmp_path: Path) -> None:
    mesh = grid(4, 4)
    whole = meshio.Mesh(np.column_stack([mesh.points, 0.0 * mesh.points[:, 0]]), mesh.cells)
    meshio.write(tmp_path / "mesh.vtu", whole, compression=compression)
    np.testing.assert_array_equal(load(tmp_path / "mesh.vtu").points, mesh.points)
    np.testing.assert_array_equal(load(tmp_path / "mesh.vtu").cells[0].data, mesh.cells[0].data)


def _head(version: str) -> str:
    return f"$MeshFormat\n{version} 0 8\n$EndMeshFormat\n"


VTK = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET "

#: files of a few bytes by name, and what is said
LIES = {
    "nodes.msh": (f"{_head('2.2')}$Nodes\n{N}\n1 0 0 0\n$EndNodes\n", "meshio cannot read it"),
    "nodes4.msh": (f"{_head('4.1')}$Nodes\n1 {N} 1 {N}\n2 1 0 {N}\n1\n2\n", "meshio cannot read it"),
    "elements.msh": (f"{_head('2.2')}$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n{N}\n1 2 2 1 1 1 1 1\n", "cannot read it"),
    "points.vtk": (f"{VTK}UNSTRUCTURED_GRID\nPOINTS {N} double\n0 0 0\n", "meshio cannot read it"),
    "grid.vtk": (f"{VTK}STRUCTURED_POINTS\nDIMENSIONS 900 900 900\nORIGIN 0 0 0\nSPACING 1 1 1\n", "DATASET is STRUCTURED_P"),
    "zeros.xdmf": (
        f'<Xdmf Version="3.0"><DataItem Dimensions="{N} 3" Format="Binary">/dev/zero</DataItem></Xdmf>',
        "an array of Format Binary; expected XML or HDF",
    ),
    "broken.xdmf": ("<Xdmf", "it is no XML"),
    "fluent.msh": ("(0 grid)\n", r"first line is not \$MeshFormat; expected a file of gmsh"),
    "sets.inp": (
        "*NODE\n1,0,0\n2,0,1\n*NSET, NSET=a0\n1,2\n" + "".join(f"*NSET, NSET=a{i + 1}\n{f'a{i},' * 20}\n" for i in range(9)),
        "the sets have more than 10,000,000 entries",
    ),
    "range.inp": ("*NODE\n1,0,0\n*NSET, NSET=a, GENERATE\n" + "1, 9000000, 1\n" * 9, "the sets have more than"),
}  # fmt: skip


@pytest.mark.parametrize("name", LIES)
def test_a_file_that_says_more_than_it_has(name: str, tmp_path: Path) -> None:
    text, message = LIES[name]
    (tmp_path / name).write_text(text)
    assert_refused(tmp_path / name, message)


@pytest.mark.parametrize("suffix", [".dat", ".ele", ".mdpa", ".node", ".off", ".ply", ".tec", ".wkt"])
def test_formats_whose_reader_does_not_end_are_refused(suffix: str, tmp_path: Path) -> None:
    (tmp_path / f"plate{suffix}").write_text("4 2 0 0\n")
    assert_refused(tmp_path / f"plate{suffix}", f"files {suffix} are not read")


def test_packed_and_large_files_are_refused(tmp_path: Path) -> None:
    for name in ("a.msh", "a.vol.gz"):
        (tmp_path / name).write_bytes(gzip.compress(b"$MeshFormat\n"))
        assert_refused(tmp_path / name, "it is packed; expected it unpacked")
    with (tmp_path / "sparse.msh").open("wb") as file:
        os.truncate(file.fileno(), 40_000_000_000)
    assert_refused(tmp_path / "sparse.msh", "it has 40000 MB; expected at most 500")


def test_large_arrays_of_hdf5_are_refused(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("p", shape=(10**9, 3), dtype="f8", chunks=(10**5, 3), compression="gzip")
    item = f'<DataItem Dimensions="{10**9} 3" Format="HDF">a.h5:/p</DataItem>'
    (tmp_path / "a.xdmf").write_text(f'<Xdmf Version="3.0">{item}</Xdmf>')
    (tmp_path / "a.med").write_bytes((tmp_path / "a.h5").read_bytes())
    for name in ("a.xdmf", "a.med"):
        assert_refused(tmp_path / name, r"it unpacks to 2\.4e\+04 MB")
