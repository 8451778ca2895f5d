"""Packed .vtu files, unpacked with a bound: meshio has none, and takes the square of the time for many blocks."""

from __future__ import annotations

import lzma
import re
import tempfile
import zlib
from base64 import b64decode, b64encode
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..errors import MeshError
from .limits import UNPACKED, refused

#: bytes that are unpacked at a time
_PIECE = 1_000_000


@contextmanager
def unpacked_vtu(path: Path) -> Iterator[Path]:
    """The same file, or a temporary one with the same arrays, not packed; MeshError if it is larger than a mesh, or its arrays
    are not as its head says."""
    head, mark, rest = path.read_bytes().partition(b"<AppendedData")
    if b"compressor" not in head:
        yield path
        return
    try:
        root = ElementTree.fromstring(head + b"</VTKFile>" if mark else head)
        _unpack(path, root, rest)
    except (ElementTree.ParseError, KeyError, TypeError, ValueError, IndexError, zlib.error, lzma.LZMAError) as error:
        if isinstance(error, MeshError):
            raise
        raise refused(path, f"its packed arrays cannot be read: {error}") from None
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, "mesh.vtu")
        ElementTree.ElementTree(root).write(copy)
        yield copy


def _unpack(path: Path, root: ElementTree.Element, rest: bytes) -> None:
    """Put every packed array in its place, as it is without packing."""
    packing = {"vtkZLibDataCompressor": _zlib, "vtkLZMADataCompressor": _lzma}[root.attrib.pop("compressor")]
    item = np.dtype(root.get("header_type", "UInt32").lower())
    item = item.newbyteorder(">" if root.get("byte_order") == "BigEndian" else "<")
    attributes, _, appended = rest.partition(b">")
    is_raw = re.search(rb"encoding\s*=\s*[\"']raw", attributes) is not None
    appended = appended[appended.find(b"_") + 1 : appended.rfind(b"</AppendedData>")]
    left = UNPACKED
    for each in root.iter("DataArray"):
        kind = each.get("format")
        if kind not in ("binary", "appended"):
            continue
        data = appended[int(each.attrib.pop("offset")) :] if kind == "appended" else (each.text or "").strip().encode()
        content = []
        for block in _blocks(data, item, is_raw and kind == "appended"):
            for piece in packing(block):
                left -= len(piece)
                if left < 0:
                    raise refused(path, f"it unpacks to more than {UNPACKED / 1e6:.0f} MB; expected a mesh")
                content.append(piece)
        whole = b"".join(content)
        each.text = b64encode(np.array([len(whole)], dtype=item).tobytes() + whole).decode()
        each.set("format", "binary")


def _blocks(data: bytes, item: np.dtype[np.generic], is_raw: bool) -> Iterator[bytes]:
    """The packed blocks of an array: their number, two sizes, the packed size of each, then they themselves."""

    def chars(count: int) -> int:
        return count if is_raw else -(-count // 3) * 4

    def decoded(begin: int, count: int) -> bytes:
        part = data[begin : begin + chars(count)]
        return part if is_raw else b64decode(part)[:count]

    number = int(np.frombuffer(decoded(0, item.itemsize), item)[0])
    size = item.itemsize * (3 + number)
    sizes = [int(each) for each in np.frombuffer(decoded(0, size), item)[3:]]
    body, at = decoded(chars(size), sum(sizes)), 0
    for each in sizes:
        yield body[at : at + each]
        at += each


def _zlib(block: bytes) -> Iterator[bytes]:
    stream = zlib.decompressobj()
    piece = stream.decompress(block, _PIECE)
    while piece or not stream.eof:
        if not piece:
            raise ValueError("one is cut short")
        yield piece
        piece = stream.decompress(stream.unconsumed_tail, _PIECE)


def _lzma(block: bytes) -> Iterator[bytes]:
    stream = lzma.LZMADecompressor(memlimit=UNPACKED)
    piece = stream.decompress(block, _PIECE)
    while piece:
        yield piece
        piece = b"" if stream.eof else stream.decompress(b"", _PIECE)
    if not stream.eof:
        raise ValueError("one is cut short")
