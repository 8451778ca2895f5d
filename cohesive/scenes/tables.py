"""The tables of a scene, each a dataclass whose fields are its keys. Ranges are checked here, types in `scene`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from meshing.specimens import polylines


@dataclass(frozen=True)
class UserMesh:
    """A mesh file of the user's, plane or solid, with its crack, supports and drive.

    A place is the name of a set of the file, or a point [x, y] that is a node; of a solid mesh points and directions have
    three numbers.

    Parameters
    ----------
    file : in any format that meshio reads, lengths in mm; relative to the scene file.
    thickness : of a plane mesh, mm; a solid one has none.
    crack : name of a set of line cells or nodes on the path, or a polyline (or a list of them) along element edges; of a
        solid mesh, name of a set of triangles or quadrilaterals on the crack surface, or of its nodes.
    supports : list of {at = place, direction = [x, y]}: no motion of these nodes along the direction.
    drive : {at = place, direction = [x, y]}: these nodes move together along the direction.
    gauge_minus, gauge_plus : places between which the opening is measured, positive where they part; without them the
        mean jump over the crack, or over a band that is a row of quadrilaterals.
    band : name of a set of elements, the crack band of the smeared model with band.where = "path". A row of
        quadrilaterals, one element wide, is treated as that of a built-in specimen; in any other set of elements the
        crack may form as with "everywhere".
    """

    file: str
    crack: Any
    supports: Any
    drive: Any
    thickness: float | None = None
    gauge_minus: Any = None
    gauge_plus: Any = None
    band: str | None = None

    def __post_init__(self) -> None:
        if self.thickness is not None and not self.thickness > 0:
            raise ValueError(f"thickness = {self.thickness!r}: expected a number above 0")
        if not isinstance(self.crack, str):
            object.__setattr__(self, "crack", polylines(self.crack))
        if not isinstance(self.supports, list) or not self.supports:
            raise ValueError(f"supports = {self.supports!r}: expected a list of {{at = ..., direction = [x, y]}}")
        object.__setattr__(self, "supports", [_motion("supports", entry) for entry in self.supports])
        object.__setattr__(self, "drive", _motion("drive", self.drive))
        if (self.gauge_minus is None) != (self.gauge_plus is None):
            raise ValueError("gauge_minus, gauge_plus: expected both or none")
        for name in ("gauge_minus", "gauge_plus"):
            if getattr(self, name) is not None:
                _place(name, getattr(self, name))


def _place(name: str, value: Any) -> str | tuple[float, ...]:
    if isinstance(value, str):
        return value
    return _vector(name, value, "the name of a set or a point [x, y], in space [x, y, z]")


def _vector(name: str, value: Any, expected: str) -> tuple[float, ...]:
    try:
        components = tuple(float(c) for c in value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r}: expected {expected}") from None
    if len(components) not in (2, 3) or not all(math.isfinite(c) for c in components):
        raise ValueError(f"{name} = {value!r}: expected {expected}")
    return components


def _motion(name: str, entry: Any) -> tuple[str | tuple[float, ...], tuple[float, ...]]:
    """{at, direction} as a place and a unit vector."""
    if not isinstance(entry, dict) or set(entry) != {"at", "direction"}:
        raise ValueError(f"{name} = {entry!r}: expected {{at = ..., direction = [x, y]}}")
    direction = _vector(f"{name}.direction", entry["direction"], "two numbers [x, y], in space three")
    length = math.hypot(*direction)
    if not length > 0:
        raise ValueError(f"{name}.direction = {entry['direction']!r}: expected a vector that is not zero")
    return _place(f"{name}.at", entry["at"]), tuple(c / length for c in direction)


@dataclass(frozen=True)
class InterfaceOptions:
    """[interface]

    Parameters
    ----------
    width : width w of the crack plane in mm, "h" for eq. (21) as printed, or left out: the rule of `default_width`.
    quadrature : "nodal" or "gauss".
    """

    width: float | str | None = None
    quadrature: str = "nodal"

    def __post_init__(self) -> None:
        if self.width is not None and self.width != "h" and (isinstance(self.width, str) or not self.width > 0):
            raise ValueError(f"width = {self.width!r}: expected a number above 0 in mm, or 'h'")
        _one_of(self, "quadrature", "nodal", "gauss")


@dataclass(frozen=True)
class BandOptions:
    """[band], of the smeared model.

    Parameters
    ----------
    width : of the band along the path in mm; default: mesh.crack_size.
    where : "path": the crack path is a row of quadrilaterals, one element wide (first-order triangles would lock
        and lead the crack along the mesh); "everywhere": the crack may form in any element, refined near the path.
    max_cracks : crack planes at a point.
    threshold_angle : least angle between two of them, degrees.
    tol : on the stress error of the local iteration, relative to ft; the paper takes 1e-6.
    shear_scaling : eq. (25); without it shear contact depends on the mesh (the paper's Figure 15a).
    """

    width: float | None = None
    where: str = "path"
    max_cracks: int = 3
    threshold_angle: float = 60.0
    tol: float = 1e-11
    shear_scaling: bool = True

    def __post_init__(self) -> None:
        if self.width is not None and not self.width > 0:
            raise ValueError(f"width = {self.width!r}: expected a number above 0 in mm")
        _one_of(self, "where", "path", "everywhere")
        if not 1 <= self.max_cracks <= 3:
            raise ValueError(f"max_cracks = {self.max_cracks!r}: expected 1, 2 or 3")
        if not 0 < self.threshold_angle <= 90:
            raise ValueError(f"threshold_angle = {self.threshold_angle!r}: expected above 0 and at most 90 degrees")
        if not 1e-13 <= self.tol <= 1e-2:
            raise ValueError(f"tol = {self.tol!r}: expected a number between 1e-13 and 0.01")


@dataclass(frozen=True)
class ModelOptions:
    """[model]

    Parameters
    ----------
    kind : "discrete" (zero-thickness interface elements) or "smeared" (crack band).
    plane : "stress" or "strain". In three dimensions the specimens that are extruded have front and back held along z for
        "strain", and free for "stress"; for a single-crack-3d and a solid mesh "strain" has no meaning and is refused.
    half : model one half of a body that is symmetric about its crack; loads and energies are those of the whole.
        Discrete only.
    """

    kind: str = "discrete"
    plane: str = "stress"
    half: bool = False

    def __post_init__(self) -> None:
        _one_of(self, "kind", "discrete", "smeared")
        _one_of(self, "plane", "stress", "strain")


@dataclass(frozen=True)
class SolverOptions:
    """[solver]

    Parameters
    ----------
    tol : relative tolerance on residual and correction.
    reduction : "condensed" eliminates the elastic bulk once, "none" works on all unknowns, "auto" takes the one with less
        work in an iteration, as counted from the matrices' patterns, if it finds room in 60 % of the memory. "petsc" factors
        everything with PETSc, on all processes that mpiexec started, for meshes that outgrow one machine; it needs the
        optional package petsc4py.
    tangent : "consistent" (Newton's method, quadratic convergence) or "secant": the stiffness at constant damage in every
        iteration. It converges linearly: a step may take 1000 iterations instead of 25.
    largest_step : up to which multiple of the nominal step a step grows while the iteration converges easily; at least 1.
        What happens within a step is not seen: a peak is met less closely.
    """

    tol: float = 1e-4
    condensation: str = "auto"
    step_growth: float = 1.0

    def __post_init__(self) -> None:
        if not 1e-13 <= self.tol <= 1e-1:
            raise ValueError(f"tol = {self.tol!r}: expected a number between 1e-13 and 0.1")
        _one_of(self, "condensation", "auto", "always", "never", "petsc")
        if not self.step_growth >= 1:
            raise ValueError(f"step_growth = {self.step_growth!r}: expected a number of at least 1")

    reduction = property(lambda self: {"always": "condensed", "never": "none"}.get(self.condensation, self.condensation))
    largest_step = property(lambda self: self.step_growth)
    tangent = "consistent"


@dataclass(frozen=True)
class ReferenceOptions:
    """[reference]

    Parameters
    ----------
    file : CSV with columns opening and load, or opening, load_min and load_max (mm, N), `#` starts a comment;
        relative to the scene file.
    label : its name in the legend.
    """

    file: str
    label: str = "measured"


@dataclass(frozen=True)
class OutputOptions:
    """[output]

    Parameters
    ----------
    frames : number of states that are written as VTU, besides the one at the peak.
    """

    frames: int = 5

    def __post_init__(self) -> None:
        if self.frames < 0:
            raise ValueError(f"frames = {self.frames!r}: expected a whole number of at least 0")


def _one_of(options: object, name: str, *allowed: str) -> None:
    if getattr(options, name) not in allowed:
        raise ValueError(f"{name} = {getattr(options, name)!r}: expected {' or '.join(map(repr, allowed))}")
