"""Single-line changes of a source, as a slip of the pen makes them: what `tests.mutants` tries on the tests."""

from __future__ import annotations

import ast
import copy
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

COMPARED: dict[type, tuple[type, ...]] = {
    ast.Lt: (ast.LtE, ast.GtE), ast.LtE: (ast.Lt, ast.Gt), ast.Gt: (ast.GtE, ast.LtE), ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.Is: (ast.IsNot,), ast.IsNot: (ast.Is,), ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}  # fmt: skip
OPERATED: dict[type, type] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult,
    ast.Pow: ast.Mult, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
PAIRS = ("min max", "any all", "minimum maximum", "fmin fmax", "argmin argmax", "floor ceil", "sin cos", "zeros ones")
NAMED = {a: b for pair in PAIRS for a, b in (pair.split(), pair.split()[::-1])}

#: constants up to here are tolerances: doubled they would be as good, a thousand times larger they must show
SMALL = 1e-4


@dataclass(frozen=True)
class Mutant:
    """A change of one piece of a file.

    Attributes
    ----------
    file : path below the root
    line, last : lines of the statement that it is in, or of its head
    place : function or class in which it is, dotted
    piece : (first, end) byte in the source that `new` replaces
    old, new : Python text
    repeat : how many equal changes stand before it in the same place
    """

    file: str
    line: int
    last: int
    place: str
    piece: tuple[int, int]
    old: str
    new: str
    repeat: int = 0

    @property
    def name(self) -> str:
        again = f" #{self.repeat + 1}" if self.repeat else ""
        return f"{self.file} {self.place or 'module'}: {' '.join(self.old.split())} -> {' '.join(self.new.split())}{again}"

    def applied(self, source: bytes) -> bytes:
        first, end = self.piece
        return source[:first] + self.new.encode() + source[end:]


def _variants(node: ast.AST) -> Iterator[ast.AST]:
    """Changed copies of an expression."""
    new = copy.deepcopy(node)
    match new:
        case ast.Compare(ops=[operator]):
            for other in COMPARED[type(operator)]:
                new.ops = [other()]
                yield new
        case ast.BinOp() | ast.BoolOp() if type(new.op) in OPERATED:
            new.op = OPERATED[type(new.op)]()
            yield new
        case ast.UnaryOp(operand=operand):
            yield operand
        case ast.Call(func=ast.Name(id=name) as function) if name in NAMED:
            function.id = NAMED[name]
            yield new
        case ast.Call(func=ast.Attribute(attr=name) as function) if name in NAMED:
            function.attr = NAMED[name]
            yield new
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield ast.Constant(value + 1)
        case ast.Constant(value=float(value)):
            yield ast.Constant(1.0 if value == 0.0 else value * (1000.0 if abs(value) <= SMALL else 2.0))
        case ast.IfExp(test=test):
            new.test = ast.UnaryOp(ast.Not(), test)
            yield new


def _is_text(node: ast.AST) -> bool:
    """What is for readers or for mypy only: messages, imports, hints, decorators' arguments, TYPE_CHECKING."""
    match node:
        case ast.Raise() | ast.JoinedStr() | ast.Import() | ast.ImportFrom() | ast.Assert() | ast.arg():
            return True
        case ast.Call(func=ast.Name(id="isinstance" | "cast" | "key" | "_key")):
            return True
        case ast.Expr(value=ast.Constant(value=str())):
            return True
        case ast.If(test=ast.Name(id="TYPE_CHECKING")):
            return True
    return False


class _Finder:
    def __init__(self, file: str, source: bytes) -> None:
        self.file, self.source = file, source
        self.starts = [0]
        for line in source.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))
        self.found: list[Mutant] = []
        self.count: Counter[tuple[str, str, str]] = Counter()

    def _add(self, node: ast.expr | ast.stmt, new: str, lines: tuple[int, int], place: str) -> None:
        assert node.end_lineno is not None and node.end_col_offset is not None
        piece = self.starts[node.lineno - 1] + node.col_offset, self.starts[node.end_lineno - 1] + node.end_col_offset
        repeat = self.count[place, ast.unparse(node), new]
        self.count[place, ast.unparse(node), new] += 1
        self.found.append(Mutant(self.file, *lines, place, piece, ast.unparse(node), new, repeat))

    def expression(self, node: ast.AST, lines: tuple[int, int], place: str) -> None:
        if _is_text(node):
            return
        if isinstance(node, ast.expr):
            for new in _variants(node):
                text = ast.unparse(new)
                self._add(node, text if isinstance(new, ast.Constant) else f"({text})", lines, place)
        for child in ast.iter_child_nodes(node):
            self.expression(child, lines, place)

    def statement(self, node: ast.stmt, place: str) -> None:
        if _is_text(node):
            return
        children = list(ast.iter_child_nodes(node))
        inner = [child for child in children if isinstance(child, ast.stmt | ast.excepthandler | ast.match_case)]
        head = [child for child in children if child not in inner]
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                place = f"{place}.{name}".lstrip(".")
                head = [*node.args.defaults, *filter(None, node.args.kw_defaults)] if isinstance(node, ast.FunctionDef) else []
            case ast.AnnAssign(value=value):
                head = [value] if value else []
        last = min([child.lineno for child in inner if isinstance(child, ast.stmt)], default=(node.end_lineno or 0) + 1) - 1
        lines = node.lineno, max(last, node.lineno)
        for child in head:
            self.expression(child, lines, place)
        match node:
            case ast.Expr(value=ast.Call()) | ast.AugAssign() | ast.Break() | ast.Continue():
                self._add(node, "pass", lines, place)
            case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]):
                self._add(node, "pass", lines, place)
            case ast.If(test=test):
                self._add(test, f"(not ({ast.unparse(test)}))", lines, place)
        for child in inner:
            for each in [child] if isinstance(child, ast.stmt) else child.body:
                self.statement(each, place)


def mutants(file: str, source: bytes) -> list[Mutant]:
    """All single changes of a file of Python: comparisons, arithmetic, and/or, min/max, any/all, constants, signs, `not`,
    conditions, removed statements."""
    finder = _Finder(file, source)
    for node in ast.parse(source).body:
        finder.statement(node, "")
    return finder.found
