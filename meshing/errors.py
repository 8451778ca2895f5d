"""Errors that name a key: of a mesh, and what those of other packages have in common with it."""

from __future__ import annotations

import re
from typing import Self

#: longer words and messages are cut: a name of thousands of characters says no more than its ends
_LONGEST_WORD, _LONGEST_TEXT = 200, 2000


def one_line(message: str) -> str:
    """A message in one line that a reader can take in: words and texts that are too long lose their middles."""
    message = message.replace("\n", "\\n").replace("\r", "\\r")
    message = re.sub(rf"\S{{{_LONGEST_WORD + 1},}}", lambda word: _cut(word[0], _LONGEST_WORD), message)
    return _cut(message, _LONGEST_TEXT)


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most // 2]}...{text[-most // 4 :]}"


class InputError(ValueError):
    """Input that cannot be used; the message names the entity, the value and what was expected.

    Attributes
    ----------
    key : what the message is about, as it is called in a scene or among parameters; "" if it is about no single one
    """

    def __init__(self, message: str = "", key: str = "") -> None:
        super().__init__(one_line(message))
        self.key = key

    @classmethod
    def at(cls, key: str, says: str) -> Self:
        """The error of a key, with which its message begins: `at("mesh.order", " = 3: expected 1 or 2")`."""
        return cls(f"{key}{says}", key)


class MeshError(InputError):
    """A geometry or mesh that cannot be used; the message names the entity, the value and what was expected.

    Attributes
    ----------
    key : dotted scene key ("mesh.order", "band.width") or a specimen's own key ("crack", "file") that the message begins
        with; "" if it names none.
    """
