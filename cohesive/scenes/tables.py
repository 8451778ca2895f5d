"""The tables of a scene, each a dataclass whose fields are its keys with their units, ranges and meanings."""

from __future__ import annotations

from dataclasses import dataclass
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
        "length of the segments by which a crack grows; default: 4 times mesh.crack_size", None, unit="mm", above=0
    )
    criterion: str = key(
        "'stress': the crack follows the ray from its tip along which the averaged hoop stress is largest; 'symmetry': it "
        "takes the direction in which it does not slide at the tip of its next segment. No segment turns by more than 75 "
        "degrees",
        "stress",
        one_of=("stress", "symmetry"),
    )
    radius: float | None = key(
        "length of the rays over which the stress is averaged; default: 3 times mesh.crack_size", None, unit="mm", above=0
    )
    starts: Any = key(
        "list of {at = [x, y], direction = [x, y]}: further cracks, from a point of a face or the end of a notch", None
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
    numbers = [c for v in vectors for c in v]
    if not all(isinstance(c, (int, float)) and not isinstance(c, bool) and abs(c) < 1e100 for c in numbers):
        return False
    return any(entry["direction"])


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
    max_cracks: int = key("crack planes at a point", 3, at_least=1, at_most=3)
    threshold_angle: float = key("least angle between two of them", 60.0, unit="degrees", above=0, at_most=90)


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
        "text table of a measured curve, or a list of them; any separator, decimal sign, encoding and number of lines before "
        "the data; units from the heading; relative to the scene file"
    )
    label: str = key("its name in the legend", "measured")
    x: str | int | None = key(
        "name or number of the column with the motion; default: CMOD, else an opening, a deflection, a displacement, one that "
        "names its unit first; the mean of two gauges of one quantity",
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

    def __post_init__(self) -> None:
        super().__post_init__()
        files = self.files
        if not files or not all(isinstance(name, str) for name in files) or len(set(files)) < len(files):
            raise ParameterError.at("file", f" = {self.file!r}: expected a file or a list of different files")
        columns = self.y if isinstance(self.y, list) else [self.y]
        if not all(isinstance(name, (str, int, type(None))) and not isinstance(name, bool) for name in columns):
            raise ParameterError.at("y", f" = {self.y!r}: expected the name or number of a column, or a list of two")
        if isinstance(self.y, list) and (len(self.y) != 2 or None in self.y):
            raise ParameterError.at("y", f" = {self.y!r}: expected a list of two columns, lower and upper bound")
        for name, known in (("x_unit", LENGTHS), ("y_unit", FORCES)):
            if (unit := getattr(self, name)) is not None:
                factor_of(unit, known, name)

    @property
    def files(self) -> list[str]:
        """The files, one or several."""
        return self.file if isinstance(self.file, list) else [self.file]


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
