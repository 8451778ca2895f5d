"""The changes that a mutation trial makes: each kind once, in its place, and none to what is for readers only."""

from __future__ import annotations

import ast

from tests.mutation import mutants

SOURCE = '''"""Text."""
import math

LIMIT = 1e-5


class Ring:
    def size(self, a: float, b: float = 2.0) -> float:
        """1 + 1."""
        if not a < b and self.open:
            raise ValueError(f"{a + 1} is too large" + "!")
        self.last = min(a, b)
        é = "ß"; return -a * b
'''


def test_each_kind_of_change_is_made_in_its_place() -> None:
    found = mutants("ring.py", SOURCE.encode())
    lines = SOURCE.splitlines()
    changed = {}
    for mutant in found:
        new = mutant.applied(SOURCE.encode()).decode()
        ast.parse(new)
        (number,) = [i for i, (old, other) in enumerate(zip(lines, new.splitlines(), strict=True)) if old != other]
        changed[new.splitlines()[number].strip()] = mutant.place, mutant.line == number + 1
    assert changed == {
        "LIMIT = 0.01": ("", True),
        "def size(self, a: float, b: float = 4.0) -> float:": ("Ring.size", True),
        "if (not a < b or self.open):": ("Ring.size", True),
        "if (a < b) and self.open:": ("Ring.size", True),
        "if not (a <= b) and self.open:": ("Ring.size", True),
        "if not (a >= b) and self.open:": ("Ring.size", True),
        "if (not (not a < b and self.open)):": ("Ring.size", True),
        "pass": ("Ring.size", True),
        "self.last = (max(a, b))": ("Ring.size", True),
        'é = "ß"; return (-a / b)': ("Ring.size", True),
        'é = "ß"; return (a) * b': ("Ring.size", True),
    }
    assert len({mutant.name for mutant in found}) == len(found)
