"""Sheets of a workbook (.xlsx) as tables of text."""

from __future__ import annotations

import io
import warnings
import zipfile
from datetime import date, datetime

from .fields import TableError

#: what a workbook begins with, and one of the time before 2007
MARK, OLD_MARK = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"


def sheets_of(content: bytes, largest: int) -> dict[str, str]:
    """The sheets of a workbook by name, each as lines of fields with tabs between them; a row is a line.

    Parameters
    ----------
    largest : bytes, of which the unpacked file may not have more.

    Raises
    ------
    TableError
        If it is no workbook, or if openpyxl, the optional extra `excel`, is missing.
    """
    try:
        from openpyxl import load_workbook
    except ImportError:
        raise TableError(
            "is a workbook: expected openpyxl (pip install cohesive-cracks[excel]), or a sheet that was exported as text"
        ) from None
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as packed:
            if sum(each.file_size for each in packed.infolist()) > largest:
                raise TableError(f"has more than {largest / 1e6:.0f} MB when unpacked")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of styles and validations, which no number depends on
            book = load_workbook(io.BytesIO(content), data_only=True)
    except (zipfile.BadZipFile, KeyError, ValueError, OSError, SyntaxError, EOFError) as error:
        if isinstance(error, TableError):
            raise
        raise TableError(f"is no workbook that can be read: {str(error).splitlines()[0] if str(error) else error!r}") from None
    return {
        sheet.title: "\n".join("\t".join(map(_text, row)) for row in sheet.iter_rows(values_only=True))
        for sheet in book.worksheets
    }


def _text(value: object) -> str:
    """A cell; a number has a decimal point, so that none is taken for thousands."""
    if value is None:
        return ""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return repr(float(value))
    if isinstance(value, (datetime, date)):
        return value.isoformat()
    return " ".join(str(value).replace('"', "").split())
