"""The tables of a scene, each a dataclass whose fields are its keys with their units, ranges and meanings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from meshing.keys import check_keys, key

from ..errors import ParameterError
from ..measured.units import FORCES, LENGTHS, factor_of

#: frames that a run may write: each is a file
MOST_FRAMES = 100_000


class Table:
    """A table whose keys are in their ranges; ParameterError for one that is not."""

    def __post_init__(self) -> None:
        check_keys(self, ParameterError)


@dataclass(frozen=True)
class GrowOptions(Table):
    """[grow]: the search for crack paths, with specimen.crack = "grow"."""

    segment: float | None = key(
        "length of the segments by which a crack grows; default: two thirds of radius", None, unit="mm", above=0
    )
    criterion: str = key(
        "'stress': the crack follows the ray from its tip along which the averaged hoop stress is largest; 'symmetry': it "
        "takes the direction in which it does not slide at the tip of its next segment. No segment turns by more than 75 "
        "degrees",
        "stress",
        one_of=("stress", "symmetry"),
    )
    radius: float | None = key(
        "length of the rays over which the stress is averaged; default: .07 E Gf/ft^2, at most a quarter of "
        "the ligament; at least 3 times mesh.crack_size",
        None,
        unit="mm",
        above=0,
    )
    starts: Any = key(
        "list of {at = [x, y], direction = [x, y]}: further cracks, from a point of a face or the end of a notch; without "
        "any, in a body without a notch, one starts across the largest principal stress at a face of the elastic body",
        None,
    )
    extrude: bool = key(
        "with model.dimension = 3: find the path in the plane and extrude it; crack fronts are given, not found",
        False,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.starts is None:
            object.__setattr__(self, "starts", [])
        elif not isinstance(self.starts, list) or not all(map(_is_start, self.starts)):
            raise ParameterError.at("starts", f" = {self.starts!r}: expected a list of {{at = [x, y], direction = [x, y]}}")


def _is_start(entry: Any) -> bool:
    """Whether an entry of `starts` has two vectors in the plane, the direction not zero."""
    if not isinstance(entry, dict) or set(entry) != {"at", "direction"}:
        return False
    vectors = list(entry.values())
    if not all(isinstance(v, (list, tuple)) and len(v) == 2 for v in vectors):
        return False
    return all(_is_number(c) for v in vectors for c in v) and any(entry["direction"])


@dataclass(frozen=True)
class InterfaceOptions(Table):
    """[interface]: the zero-thickness elements of the discrete model."""

    width: float | str | None = key(
        "width w of the crack plane, or 'h': eq. (21) as printed; default: the smaller of 0.25 % of the crack length and "
        "0.1 % of E Gf/ft^2",
        None,
        unit="mm",
        above=0,
    )
    quadrature: str = key("'nodal' (Newton-Cotes) or 'gauss'", "nodal", one_of=("nodal", "gauss"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.width, str) and self.width != "h":
            raise ParameterError.at("width", f" = {self.width!r}: expected a number above 0, in mm, or 'h'")


@dataclass(frozen=True)
class BandOptions(Table):
    """[band]: the crack band of the smeared model."""

    width: float | None = key(
        "width of the band along the path; default: the smaller of 1 % of the crack length and 1/60 of E Gf/ft^2, at most the "
        "notch's width",
        None,
        unit="mm",
        above=0,
    )
    where: str = key(
        "'path': the crack path is a row of quadrilaterals, one element wide; 'everywhere': the crack may form in any "
        "element, refined near the path",
        "path",
        one_of=("path", "everywhere"),
    )
    planes: str | None = key(
        "'path': each point has one crack plane, which lies on the path as a discrete crack does; 'principal': planes form "
        "across the principal stress that passes ft, as in the paper. Default: 'path' if the band follows a path",
        None,
        one_of=("path", "principal"),
    )
    max_cracks: int = key("crack planes at a point with planes = 'principal'", 3, at_least=1, at_most=3)
    threshold_angle: float = key("least angle between two of them", 60.0, unit="degrees", above=0, at_most=90)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.planes == "path" and self.where == "everywhere":
            raise ParameterError.at(
                "planes", " = 'path': with where = 'everywhere' cracks follow no path; expected 'principal'"
            )


@dataclass(frozen=True)
class ModelOptions(Table):
    """[model]"""

    kind: str = key(
        "'discrete' (zero-thickness interface elements) or 'smeared' (crack band)", "discrete", one_of=("discrete", "smeared")
    )
    plane: str = key(
        "'stress' or 'strain'; of an extruded specimen front and back are free or held", "stress", one_of=("stress", "strain")
    )
    dimension: int | None = key(
        "2 or 3; a 2D specimen is extruded over its thickness if it is 3. Default: that of the specimen, 2 if it has both",
        None,
        at_least=2,
        at_most=3,
    )
    half: bool = key(
        "model one half of a body that is symmetric about its crack, loads and energies being those of the whole; "
        "discrete only",
        False,
    )


@dataclass(frozen=True)
class SolverOptions(Table):
    """[solver]"""

    tol: float = key("relative tolerance on residual and correction", 1e-4, at_least=1e-13, at_most=0.1)
    condensation: str = key(
        "'always' eliminates the elastic bulk once, 'never' works on all unknowns, 'auto' takes the one with less work in an "
        "iteration if its matrices fit in 60 % of the memory; 'petsc' factors all with PETSc on all ranks of mpiexec",
        "auto",
        one_of=("auto", "always", "never", "petsc"),
    )
    step_growth: float = key(
        "multiple of the nominal step up to which a step grows while the iteration converges easily; a peak is met "
        "less closely",
        1.0,
        at_least=1,
    )


@dataclass(frozen=True)
class ReferenceOptions(Table):
    """[reference]: measured curves."""

    file: str | list[str] = key(
        "table of a measured curve, as text or xlsx (extra excel), or a list of them; any separator, decimal sign, encoding "
        "and number of lines before the data; units from the heading; relative to the scene file"
    )
    label: str = key("its name in the legend", "measured")
    block: str | int | None = key(
        "name or number of the specimen in a file that holds several, one below the other or side by side", None
    )
    sheet: str | int | None = key("name or number of the sheet of a workbook; default: the only one with a table", None)
    x: str | int | list[str | int] | None = key(
        "name or number of the column with the motion, or a list of gauges of which the mean counts; default: CMOD, else an "
        "opening, a deflection, a displacement, one that names its unit first; the mean of two gauges of one quantity",
        None,
    )
    y: str | int | list[str | int] | None = key(
        "name or number of the column with the load, or a list of two with the bounds of a band; default: load_min and "
        "load_max, else the load that changes and names its unit; two loads are asked about",
        None,
    )
    x_unit: str | None = key("unit of x, as 'um', '10^-3 mm'; '-mm' turns the sign. Default: from the heading, else mm", None)
    y_unit: str | None = key("unit of y, as 'kN'. Default: from the heading, else N", None)
    against: str | None = key("column of the history that x is; default: that which its name says", None)
    x_offset: float | list[float] | None = key(
        "what the gauge shows before the test, taken off x: one for all files, or one for each; `fit` may vary it. Default: "
        "of a gauge that was not set to zero what it shows first, else nothing",
        None,
        unit="mm",
    )
    y_offset: float | None = key("what the load cell shows before the test, taken off y", None, unit="N")
    rows: list[int] | None = key("[first, last]: the rows of data that count, the first is 1; default: all", None)
    from_load: float | None = key("rows before the load reaches this, as in seating, are left out", None, unit="N", above=0)
    toe: list[float] | None = key(
        "[low, high], as [0.2, 0.4]: parts of the largest load between which the rise is taken as a straight line, which is "
        "extended to no load, from where x counts; rows before it are left out",
        None,
    )
    smooth: int | None = key("number of neighbouring rows that count by their mean; default: each row counts", None, above=1)

    def __post_init__(self) -> None:
        super().__post_init__()
        files = self.files
        numbers = self.x_offset if isinstance(self.x_offset, list) else []
        if isinstance(self.x_offset, list) and (len(numbers) != len(files) or not all(map(_is_number, numbers))):
            raise ParameterError.at("x_offset", f" = {self.x_offset!r}: expected a number, or a list of one for each file")
        if self.rows is not None and (len(self.rows) != 2 or not all(type(row) is int for row in self.rows)):
            raise ParameterError.at("rows", f" = {self.rows!r}: expected [first, last], the first row of data is 1")
        if self.toe is not None and not (
            len(self.toe) == 2 and all(map(_is_number, self.toe)) and 0.0 <= self.toe[0] < self.toe[1] <= 1.0
        ):
            raise ParameterError.at("toe", f" = {self.toe!r}: expected [low, high], parts of the largest load, as [0.2, 0.4]")
        if self.toe is not None and self.x_offset is not None:
            raise ParameterError.at("toe", f" = {self.toe!r}: x_offset = {self.x_offset!r} says it, too; expected one of them")
        if not files or not all(isinstance(name, str) for name in files) or len(set(files)) < len(files):
            raise ParameterError.at("file", f" = {self.file!r}: expected a file or a list of different files")
        for name, given, what in (("x", self.x, "of gauges"), ("y", self.y, "of two")):
            columns = given if isinstance(given, list) else [given]
            if not columns or any(isinstance(each, bool) or not isinstance(each, (str, int, type(None))) for each in columns):
                raise ParameterError.at(name, f" = {given!r}: expected the name or number of a column, or a list {what}")
        if isinstance(self.y, list) and (len(self.y) != 2 or None in self.y):
            raise ParameterError.at("y", f" = {self.y!r}: expected a list of two columns, lower and upper bound")
        for name, known in (("x_unit", LENGTHS), ("y_unit", FORCES)):
            if (unit := getattr(self, name)) is not None:
                factor_of(unit, known, name)

    @property
    def files(self) -> list[str]:
        """The files, one or several."""
        return self.file if isinstance(self.file, list) else [self.file]

    @property
    def each(self) -> list[ReferenceOptions]:
        """The keys of each file."""
        offsets = self.x_offset if isinstance(self.x_offset, list) else [self.x_offset] * len(self.files)
        return [replace(self, file=file, x_offset=offset) for file, offset in zip(self.files, offsets, strict=True)]


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e100


#: formats of figures beside PNG
FORMATS = ("pdf", "svg")


@dataclass(frozen=True)
class OutputOptions(Table):
    """[output]"""

    frames: int = key(
        "number of states that are written as VTU, besides the one at the peak", 5, at_least=0, at_most=MOST_FRAMES
    )
    curve: Any = key(
        'what curve.png draws, as in ["deflection", "load"]: names of columns of the history, first that of the abscissa. '
        "Default: load over what was measured, else over the gauge that a stage controls, else over the opening",
        None,
    )
    formats: list[str] = key("formats of the figures beside PNG: 'pdf', 'svg'", ())
    figure_size: list[float] | None = key("width and height of the figures of curves, mm; default: by figure", None)
    dpi: int | None = key("pixels to the inch of the figures as PNG; default: by figure", None, at_least=30, at_most=1200)
    force_unit: str = key("unit of forces in the figures of curves", "N", one_of=("N", "kN"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.formats, (list, tuple)) or any(name not in FORMATS for name in self.formats):
            raise ParameterError.at(
                "formats", f" = {self.formats!r}: expected a list of some of {', '.join(map(repr, FORMATS))}"
            )
        size = self.figure_size
        is_pair = isinstance(size, list) and len(size) == 2
        if size is not None and not (is_pair and all(_is_number(side) and 20 <= side <= 1000 for side in size)):
            raise ParameterError.at("figure_size", f" = {size!r}: expected width and height, 20 to 1000 mm")
