"""How much a file may hold: one of a few kilobytes may say that it is gigabytes, and some readers would believe it."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

from ..errors import MeshError

#: bytes of a file, and of what it unpacks to: some millions of nodes, for whose run tens of gigabytes would be needed
LARGEST, UNPACKED = 500_000_000, 250_000_000

#: formats whose reader in meshio does not come to an end if the file is damaged
_ENDLESS = (".dat", ".ele", ".mdpa", ".node", ".off", ".ply", ".tec", ".wkt")

#: how packed files begin: gzip, bzip2, xz, zip, zstd
_PACKED = (b"\x1f\x8b", b"BZh", b"\xfd7zXZ", b"PK\x03\x04", b"\x28\xb5\x2f\xfd")

_HDF = b"\x89HDF"


def check_limits(path: Path) -> None:
    """Refuse a file whose reader would not end, or would take the memory of the machine; MeshError."""
    suffix = path.suffix.lower()
    if suffix in _ENDLESS:
        raise refused(path, f"files {suffix} are not read, as a damaged one has no end; expected the mesh as .vtu or .msh")
    if (size := path.stat().st_size) > LARGEST:
        raise refused(path, f"it has {size / 1e6:.0f} MB; expected at most {LARGEST / 1e6:.0f}")
    with path.open("rb") as file:
        begin = file.read(200)
    if begin.startswith(_PACKED):
        raise refused(path, "it is packed; expected it unpacked")
    if suffix == ".msh" and begin.split(None, 1)[:1] != [b"$MeshFormat"]:
        raise refused(path, "its first line is not $MeshFormat; expected a file of gmsh (of meshio: file_format='gmsh22')")
    if begin.startswith(_HDF):
        _check_hdf(path, path)
    elif suffix == ".vtk":  # of other grids a few numbers stand for all nodes
        for kind in re.findall(rb"^\s*DATASET\s+(\w+)", path.read_bytes(), re.MULTILINE | re.IGNORECASE):
            if kind.upper() != b"UNSTRUCTURED_GRID":
                raise refused(path, f"its DATASET is {kind.decode()[:40]}; expected UNSTRUCTURED_GRID")
    elif suffix in (".xdmf", ".xmf"):
        _check_xdmf(path)


def _check_xdmf(path: Path) -> None:
    """Refuse arrays in other files than HDF5 ones, and those that are too large."""
    try:
        items = list(ElementTree.parse(path).iter("DataItem"))
    except ElementTree.ParseError as error:
        raise refused(path, f"it is no XML: {error}") from None
    for item in items:
        kind, text = item.get("Format", "XML"), (item.text or "").strip()
        if kind not in ("XML", "HDF"):
            raise refused(path, f"an array of Format {kind}; expected XML or HDF")
        if kind == "HDF" and (other := path.resolve().parent / text.partition(":")[0]).is_file():
            _check_hdf(path, other)


def _check_hdf(path: Path, other: Path) -> None:
    """Refuse arrays of an HDF5 file that are larger than a mesh."""
    try:
        import h5py
    except ModuleNotFoundError:  # which the reader says too
        return
    sizes: list[int] = []
    with h5py.File(other, "r") as file:
        file.visititems(lambda _, each: sizes.append(getattr(each, "nbytes", 0)))
    if sum(sizes) > UNPACKED:
        raise refused(path, f"it unpacks to {sum(sizes) / 1e6:.3g} MB; expected at most {UNPACKED / 1e6:.0f}")


def refused(path: Path, what: str) -> MeshError:
    """The error that names a file."""
    return MeshError.at("file", f" = '{path}': {what}")
