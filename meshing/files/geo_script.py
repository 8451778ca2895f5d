"""Which scripts of gmsh's geometry are run without asking: those that only describe a shape.

A .geo file is a program: it may run other programs, write files and loop for ever. What stands here is the list of statements
that cannot. Everything else is refused with its line. What is accepted is written anew from its tokens.

Expressions are followed, since a range and a list may grow without end; a number that only gmsh knows, as `newp`, may stand
anywhere but in a range.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field

#: entries that a list may have, characters that a file may have, levels of brackets
_MOST_ENTRIES, _MOST_CHARACTERS, _DEEPEST = 100_000, 10_000_000, 50

_TOKEN = re.compile(
    r"""(?P<space>\s+|//[^\n]*|/\*.*?\*/)
    |(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
    |(?P<string>"[^"\n]*")
    |(?P<name>[A-Za-z_]\w*)
    |(?P<sign>\+=|-=|\*=|/=|[-+*/%^(){}\[\],;:=])""",
    re.VERBOSE | re.DOTALL,
)

#: functions of numbers with one argument, and with two
_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "Sqrt": math.sqrt, "Sin": math.sin, "Cos": math.cos, "Tan": math.tan, "Asin": math.asin, "Acos": math.acos,
    "Atan": math.atan, "Sinh": math.sinh, "Cosh": math.cosh, "Tanh": math.tanh, "Exp": math.exp, "Log": math.log,
    "Log10": math.log10, "Fabs": math.fabs, "Abs": math.fabs, "Floor": math.floor, "Ceil": math.ceil, "Round": round,
}  # fmt: skip
_FUNCTIONS_OF_TWO: dict[str, Callable[[float, float], float]] = {
    "Atan2": math.atan2, "Fmod": math.fmod, "Modulo": math.fmod, "Hypot": math.hypot, "Min": min, "Max": max,
}  # fmt: skip

#: numbers that gmsh knows: the next free tags
_TAGS = {"newp", "newl", "newc", "newll", "newcl", "news", "newreg"}

#: entities that a statement makes, as Point(1) = {...}; a tuple is a name of two words
_MADE = {
    ("Point",), ("Line",), ("Circle",), ("Ellipse",), ("Spline",), ("BSpline",), ("Bezier",), ("Line", "Loop"),
    ("Curve", "Loop"), ("Plane", "Surface"), ("Rectangle",), ("Disk",),
}  # fmt: skip
_BOOLEAN = {"BooleanUnion", "BooleanDifference", "BooleanIntersection", "BooleanFragments"}
_ENTITIES = {"Point", "Line", "Curve", "Surface"}
_SIZES = {("Characteristic", "Length"), ("MeshSize",)}
_FACTORIES = {'"OpenCASCADE"', '"Built-in"'}

#: words that are no names of numbers
_RESERVED = {word for words in _MADE | _SIZES for word in words} | _BOOLEAN | _ENTITIES | {"Physical", "SetFactory", "Delete"}


class Refused(ValueError):
    """A statement that is not on the list: `line`, from 1, and `text`, its beginning."""

    def __init__(self, line: int, text: str, why: str = "") -> None:
        super().__init__(f"line {line}, {text!r}{': ' if why else ''}{why}")
        self.line, self.text = line, text


def harmless(script: str) -> str:
    """The statements of a script, written anew, if all of them are harmless.

    Points, lines, circles, ellipses, splines, rectangles, disks, loops, plane surfaces, Boolean operations, physical groups by
    name, sizes at points, numbers and lists of numbers with arithmetic and functions of numbers.

    Raises
    ------
    Refused
        Naming the first other statement.
    """
    if len(script) > _MOST_CHARACTERS:
        raise Refused(1, script[:40], f"the file has {len(script)} characters; expected at most {_MOST_CHARACTERS}")
    reader = _Reader(_tokens(script))
    while not reader.is_at_end:
        reader.statement()
    return " ".join(token.text for token in reader.tokens[:-1]).replace(" ;", ";\n")


@dataclass(frozen=True)
class _Token:
    kind: str
    text: str
    line: int


def _tokens(script: str) -> list[_Token]:
    """The tokens, the last one empty."""
    found, at, line = [], 0, 1
    while at < len(script):
        match = _TOKEN.match(script, at)
        if match is None:
            raise Refused(line, script[at : at + 40].split("\n")[0])
        kind = match.lastgroup or ""
        if kind != "space":
            found.append(_Token(kind, match[0], line))
        line += match[0].count("\n")
        at = match.end()
    return [*found, _Token("end", "", line)]


#: a number, or None if only gmsh knows it
_Number = float | None


@dataclass
class _Reader:
    """Reads statements; each advances `at`, or raises Refused."""

    tokens: list[_Token]
    at: int = 0
    _first: int = 0  # token of the statement
    _depth: int = 0
    _numbers: dict[str, _Number] = field(default_factory=lambda: {"Pi": math.pi})
    _lists: dict[str, list[_Number]] = field(default_factory=dict)

    @property
    def is_at_end(self) -> bool:
        return self.tokens[self.at].kind == "end"

    # -- statements ---------------------------------------------------------------------------------

    def statement(self) -> None:
        """One statement with its semicolon."""
        self._first = self.at
        words = self._words()
        if words == ["SetFactory"]:
            self._take("(")
            if self._next().text not in _FACTORIES:
                raise self._refused()
            self._take(")")
        elif words[:1] == ["Physical"] and len(words) == 2 and words[1] in _ENTITIES:
            self._physical()
        elif tuple(words) in _MADE:
            self._tag()
            self._take("=")
            self._braces()
        elif len(words) == 1 and words[0] in _BOOLEAN:
            self._boolean()
        elif tuple(words) in _SIZES:
            self._sizes()
        elif len(words) == 1 and words[0] not in _RESERVED:
            self._assignment(words[0])
        else:
            raise self._refused()
        self._take(";")

    def _words(self) -> list[str]:
        """The names with which the statement begins."""
        found = []
        while self._peek().kind == "name":
            found.append(self._next().text)
        return found

    def _physical(self) -> None:
        """("name"[, tag]) = {list}"""
        self._take("(")
        if self._next().kind != "string":
            raise self._refused("expected the name of the group, as in Physical Curve(\"support\")")
        if self._peek().text == ",":
            self._next()
            self._number()
        self._take(")")
        if self._next().text not in ("=", "+="):
            raise self._refused()
        self._braces()

    def _tag(self) -> None:
        self._take("(")
        self._number()
        self._take(")")

    def _boolean(self) -> None:
        """[(tag) =] {Surface{list}; [Delete;]}{...}"""
        if self._peek().text == "(":
            self._tag()
            self._take("=")
        for _ in range(2):
            self._take("{")
            while self._peek().text != "}":
                name = self._next().text
                if name in _ENTITIES:
                    self._braces()
                elif name != "Delete":
                    raise self._refused()
                self._take(";")
            self._take("}")

    def _sizes(self) -> None:
        """{list} = number"""
        self._braces()
        self._take("=")
        self._number()

    def _assignment(self, name: str) -> None:
        """name = number, name[] = {list}; the operators += and so on likewise."""
        if self._peek().text in ("[", "("):
            self._next()
            if self._next().text not in ("]", ")"):
                raise self._refused("expected a whole list")
            sign = self._next().text
            if sign not in ("=", "+="):
                raise self._refused()
            values = self._list()
            self._lists[name] = self._counted(self._lists.get(name, []) + values if sign == "+=" else values)
            return
        sign = self._next().text
        if sign not in ("=", "+=", "-=", "*=", "/="):
            raise self._refused()
        value, old = self._number(), self._numbers.get(name)
        self._numbers[name] = value if sign == "=" else self._applied(sign[0], old, value)

    # -- lists --------------------------------------------------------------------------------------

    def _braces(self) -> list[_Number]:
        """{list}"""
        if self._peek().text != "{":
            raise self._refused()
        return self._list()

    def _list(self) -> list[_Number]:
        """Entries in braces, a list by name, or a single number."""
        if self._peek().text != "{":
            return self._entry()
        self._deeper()
        self._next()
        values: list[_Number] = []
        while self._peek().text != "}":
            values = self._counted(values + self._entry())
            if self._peek().text != "}":
                self._take(",")
        self._next()
        self._depth -= 1
        return values

    def _entry(self) -> list[_Number]:
        """A number, a range, a list by name, or a list in braces, each with a sign if wanted."""
        if self._peek().text == "{":
            return self._list()
        start = self.at
        while self._peek().text in ("-", "+"):
            self._next()
        name = self._next()
        if name.kind == "name" and name.text in self._lists and self._peek().text in ("[", "("):
            self._next()
            if self._peek().text in ("]", ")"):
                self._next()
                return self._lists[name.text]
        self.at = start
        first = self._number()
        if self._peek().text != ":":
            return [first]
        self._next()
        last, step = self._number(), 1.0
        if self._peek().text == ":":
            self._next()
            step = self._number() or 0.0
        if first is None or last is None or not step:
            raise self._refused("expected a range of known numbers")
        count = abs(last - first) / abs(step)
        if not count < _MOST_ENTRIES:
            raise self._refused(f"expected at most {_MOST_ENTRIES} entries")
        step = math.copysign(step, last - first)
        line, parts = self.tokens[start].line, (f"{first!r}", ":", f"{last!r}", ":", f"{step!r}")
        self.tokens[start : self.at] = [_Token("number", part, line) for part in parts]  # gmsh shall count as we did
        self.at = start + len(parts)
        return [first + i * step for i in range(int(count + 1e-9) + 1)]

    def _counted(self, values: list[_Number]) -> list[_Number]:
        if len(values) > _MOST_ENTRIES:
            raise self._refused(f"expected at most {_MOST_ENTRIES} entries")
        return values

    # -- numbers ------------------------------------------------------------------------------------

    def _number(self) -> _Number:
        """A sum."""
        self._deeper()
        value = self._term()
        while self._peek().text in ("+", "-"):
            value = self._applied(self._next().text, value, self._term())
        self._depth -= 1
        return value

    def _term(self) -> _Number:
        value = self._factor()
        while self._peek().text in ("*", "/", "%"):
            value = self._applied(self._next().text, value, self._factor())
        return value

    def _factor(self) -> _Number:
        """A power, its base with a sign if wanted."""
        signs = 0
        while self._peek().text in ("-", "+"):
            signs += self._next().text == "-"
        value = self._atom()
        if self._peek().text == "^":
            self._next()
            self._deeper()
            value = self._applied("^", value, self._factor())
            self._depth -= 1
        return -value if signs % 2 and value is not None else value

    def _atom(self) -> _Number:
        token = self._next()
        if token.kind == "number":
            return self._computed(lambda: float(token.text))
        if token.text == "(":
            value = self._number()
            self._take(")")
            return value
        name = token.text
        if name in _FUNCTIONS or name in _FUNCTIONS_OF_TWO:
            return self._function(name)
        if name in _TAGS:
            return None
        if name in self._numbers and self._peek().text not in ("[", "("):
            return self._numbers[name]
        if name in self._lists and self._peek().text in ("[", "("):
            return self._item(self._lists[name])
        raise self._refused("" if token.kind != "name" else f"there is no number {name!r}")

    def _item(self, values: list[_Number]) -> _Number:
        """[number]"""
        closing = {"[": "]", "(": ")"}[self._next().text]
        at = self._number()
        self._take(closing)
        return values[int(at)] if at is not None and 0 <= at < len(values) else None

    def _function(self, name: str) -> _Number:
        """(number) or (number, number), in round or square brackets."""
        opening = self._next().text
        if opening not in ("(", "["):
            raise self._refused()
        arguments = [self._number()]
        if name in _FUNCTIONS_OF_TWO:
            self._take(",")
            arguments.append(self._number())
        self._take({"(": ")", "[": "]"}[opening])
        known = [value for value in arguments if value is not None]
        if len(known) < len(arguments):
            return None
        function: Callable[..., float] = _FUNCTIONS.get(name) or _FUNCTIONS_OF_TWO[name]
        return self._computed(lambda: float(function(*known)))

    def _applied(self, sign: str, a: _Number, b: _Number) -> _Number:
        if a is None or b is None:
            return None
        if sign == "^":
            return self._computed(lambda: math.pow(a, b))
        operations: dict[str, Callable[[], float]] = {
            "+": lambda: a + b, "-": lambda: a - b, "*": lambda: a * b, "/": lambda: a / b, "%": lambda: math.fmod(a, b)
        }  # fmt: skip
        return self._computed(operations[sign])

    def _computed(self, value: Callable[[], float]) -> float:
        try:
            number = value()
        except (ValueError, ZeroDivisionError, OverflowError):
            number = math.nan
        if not math.isfinite(number):
            raise self._refused("it has no value")
        return number

    # -- tokens -------------------------------------------------------------------------------------

    def _peek(self) -> _Token:
        return self.tokens[self.at]

    def _next(self) -> _Token:
        token = self.tokens[self.at]
        if token.kind == "end":
            raise self._refused("it does not end")
        self.at += 1
        return token

    def _take(self, text: str) -> None:
        if self._next().text != text:
            raise self._refused()

    def _deeper(self) -> None:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self._refused(f"expected at most {_DEEPEST} levels of brackets")

    def _refused(self, why: str = "") -> Refused:
        words = [token.text for token in self.tokens[self._first : self.at + 1]][:12]
        return Refused(self.tokens[self._first].line, " ".join(words).strip(), why)
