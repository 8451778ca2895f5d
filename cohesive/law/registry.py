"""Traction laws: what a law says of crack planes, what follows from that if it says no more, and the laws by name."""

from __future__ import annotations

import copy
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from types import MappingProxyType
from typing import Any, ClassVar, TypeVar

import numpy as np

from meshing.keys import check_keys

from ..arrays import Array, Mask
from ..errors import ParameterError
from .concrete import Concrete

#: tangents that differ by less than this part of the stiffness are equal
_EQUAL = 1e-10

#: change of a jump for derivatives by differences, over the onset jump
_CHANGE = 1e-4

#: openings at which a law is asked what traction is left, the last one over energy/strength, and the part of the strength that
#: is none
_TRIALS, _FURTHEST, _GONE = 64, 40.0, 1e-8


class LawKeys(ABC):
    """The keys of a law in [law], and what is known of it before it has a material and a width.

    Attributes
    ----------
    takes_width : whether the law is that of a band of some width, and its stiffness goes with 1/width: the smeared model
        needs such a law
    is_differentiated : whether `cracks.interface_variation` knows its derivatives; else whole runs are differenced
    columns : unit of each of `Law.fields`; the history has their means over the crack, as law.NAME
    """

    takes_width: ClassVar[bool] = False
    is_differentiated: ClassVar[bool] = False
    columns: ClassVar[Mapping[str, str]] = {}

    def __post_init__(self) -> None:
        check_keys(self, ParameterError)

    @abstractmethod
    def built_for(self, concrete: Concrete, width: Any, components: int = 2) -> Law:
        """The law with a material, a width of its planes (mm; one number or one for each point) and components of jumps."""

    def scales(self) -> tuple[float, float] | None:
        """Strength (MPa), the largest traction of a plane that opens, and energy of its separation (N/mm), if they are of the
        law's own keys: [material] may then leave ft and Gf out. None: they are ft and Gf."""
        return None

    def zone_length(self, concrete: Concrete) -> float:
        """What the sizes of elements and the widths go by, mm: E times energy over strength squared."""
        law = self.built_for(concrete, 1.0)
        return float(concrete.E * law.energy / law.strength**2)


class Law(LawKeys):
    """Traction of crack planes as a function of the jump between their faces, at n points at once.

    A law of one's own is a dataclass derived from it, whose fields are the keys of [law] in a scene, see `register_law`. It
    writes `stiffness`, `update` and `stored_energy`, and `scales` if they are not those of [material]; the rest follows, right
    if slower. Jumps (n, d) are [normal, shear...] in mm, opening positive, tractions in MPa; d is 2 or 3, and the axes of
    shear mean nothing in 3D. Histories (n,) or (n, h) are all that a law remembers, heat that it adds up among it;
    no method changes what it is given.

    Attributes
    ----------
    concrete : Concrete, the [material] of the scene
    width : of the band that a plane stands for, mm; an array (n,) with one for each point in the smeared model
    components : d
    makes_energy : whether closed loops at constant damage make energy, by the law's own design
    """

    concrete: Concrete
    width: Any
    components: int = 2
    makes_energy: bool = False

    # -- what a law writes ----------------------------------------------------------------------

    @abstractmethod
    def stiffness(self, components: int) -> Array:
        """Diagonal of the stiffness of the elastic plane, MPa/mm: (d,), or (n, d) for an array of widths."""

    @abstractmethod
    def update(self, jump: Array, history: Array, frozen: bool = False) -> tuple[Array, Array, Array]:
        """Tractions (n, d), consistent tangents (n, d, d) and new histories, from the last converged ones.

        At the surface where damage or sliding goes on there are two tangents: the loading one, or with `frozen` that at
        constant history.
        """

    @abstractmethod
    def stored_energy(self, jump: Array, history: Array) -> Array:
        """Energy that unloading gives back, (n,), N/mm."""

    # -- scales ---------------------------------------------------------------------------------

    @property
    def strength(self) -> float:
        """See `scales`, MPa."""
        own = self.scales()
        return float(self.concrete.ft) if own is None else own[0]

    @property
    def energy(self) -> float:
        """See `scales`, N/mm."""
        own = self.scales()
        return float(self.concrete.Gf) if own is None else own[1]

    @property
    def onset_jump(self) -> float:
        """Smallest motion that damages, mm."""
        return self.strength / float(np.max(self.stiffness(2)))

    @property
    def most_dissipated(self) -> float:
        """Energy that it can dissipate at most, N/mm; inf if nothing bounds it, as with friction."""
        return math.inf

    @property
    def separation_energy(self) -> float:
        """Energy that opening alone takes with this width, N/mm."""
        return self.energy

    # -- what follows ---------------------------------------------------------------------------

    def built_for(self, concrete: Concrete, width: Any, components: int = 2) -> Law:
        law = copy.copy(self)
        law.__dict__.update(concrete=concrete, width=width, components=components)
        return law

    def with_width(self, width: float | Array) -> Law:
        """The same law for another width, or for an array of widths."""
        return self.built_for(self.concrete, width, self.components)

    def check(self, crack_length: float) -> None:
        """Refuse numbers that cannot be meant for a crack of some length (mm); SceneError."""

    def initial(self, points: int) -> Array:
        """Histories of undamaged planes."""
        return np.zeros(points)

    def dissipation(self, jump0: Array, history0: Array, jump1: Array, history1: Array) -> tuple[Array, Array]:
        """Energy lost in a step, (n,), N/mm, and its derivative in `jump1`, (n, d). Without a formula of the law's own it
        is what the work of the step leaves, by the trapezoidal rule: the balance then checks nothing."""
        before, stored = self.update(jump0, history0)[0], self.stored_energy(jump0, history0)

        def lost(jump: Array) -> Array:
            traction, _, history = self.update(jump, history0)
            work = 0.5 * np.einsum("ni,ni->n", before + traction, jump - jump0)
            contact = self.contact_work(jump0, history0, jump, history)
            return np.asarray(work - self.stored_energy(jump, history) + stored - contact)

        return lost(jump1), self.slope(lost, jump1)

    def slope(self, value: Callable[[Array], Array], jump: Array) -> Array:
        """Derivative of a quantity of the planes, (n,), in their jumps, (n, d), by central differences."""
        step = _CHANGE * self.onset_jump
        ways = step * np.eye(jump.shape[1])
        return np.stack([(value(jump + way) - value(jump - way)) / (2.0 * step) for way in ways], axis=1)

    @property
    def is_checked(self) -> bool:
        """Whether the balance of energies checks the law, see `dissipation`."""
        return type(self).dissipation is not Law.dissipation

    def contact_traction(self, jump: Array, history: Array, traction: Array | None = None) -> Array:
        """Part of the traction whose work is counted as that of contact, (n, d), MPa; `traction` is the whole, if known."""
        return np.zeros_like(jump)

    def contact_work(self, jump0: Array, history0: Array, jump1: Array, history1: Array) -> Array:
        """Its work in a step, (n,), N/mm, by the trapezoidal rule."""
        both = self.contact_traction(jump0, history0) + self.contact_traction(jump1, history1)
        return np.asarray(0.5 * np.einsum("ni,ni->n", both, jump1 - jump0))

    def is_damaged(self, history: Array) -> Mask:
        """Whether a plane is not what it was, (n,): it remembers anything."""
        return np.asarray((history != self.initial(len(history))).reshape(len(history), -1).any(axis=1))

    def is_damaging(self, jump: Array, history: Array) -> Mask:
        """Whether this jump changes the history for good, (n,): loading and unloading tangent differ there."""
        loading, unloading = (self.update(jump, history, frozen)[1] for frozen in (False, True))
        least = _EQUAL * np.max(self.stiffness(jump.shape[1]), initial=0.0)
        return np.asarray(abs(loading - unloading).max(axis=(1, 2)) > least)

    def is_on_surface(self, jump: Array, history: Array) -> Mask:
        """Whether a plane that is damaged stands where more deformation damages it further, (n,)."""
        return np.asarray(self.is_damaging(jump, history) & self.is_damaged(history))

    def is_fully_softened(self, history: Array) -> Mask:
        """Whether opening can bring no traction back, (n,)."""
        return self._left(history) < _GONE

    def strength_left(self, history: Array) -> Array:
        """Largest traction that opening still meets, over the strength, (n,); inf for a plane that is not damaged."""
        return np.where(self.is_damaged(history), self._left(history), np.inf)

    def damage(self, history: Array) -> Array:
        """From 0 to 1, (n,), for pictures: the part of the strength that is lost."""
        return np.where(self.is_damaged(history), np.clip(1.0 - self._left(history), 0.0, 1.0), 0.0)

    def fields(self, jump: Array, history: Array) -> dict[str, Array]:
        """Quantities of its own at each point, (n,) each, by the names of `columns`: for files, pictures and the history."""
        return {}

    @property
    def advice(self) -> str:
        """What is said besides of a point without a solution."""
        return ""

    @property
    def described(self) -> str:
        """For the summary of a run."""
        return f"law {next((name for name, cls in _registered.items() if cls is type(self)), type(self).__name__)}"

    def energy_text(self, width: str) -> str:
        """What the energy of separation is, in words, with the name of the width."""
        return "energy of separation"

    def _left(self, history: Array) -> Array:
        """Largest traction of a trial opening from rest, over the strength, (n,)."""
        n, first = len(history), 0.5 * self.onset_jump
        openings = np.geomspace(first, max(_FURTHEST * self.energy / self.strength, 2.0 * first), _TRIALS)
        jump = np.zeros((n * _TRIALS, self.components))
        jump[:, 0] = np.tile(openings, n)
        law = self.with_width(np.repeat(self.width, _TRIALS)) if isinstance(self.width, np.ndarray) else self
        traction = law.update(jump, np.repeat(history, _TRIALS, axis=0))[0]
        return np.asarray(traction[:, 0].reshape(n, _TRIALS).max(axis=1, initial=0.0) / self.strength)


L = TypeVar("L", bound=type[LawKeys])

_registered: dict[str, type[LawKeys]] = {}

#: the registered laws by the names that a scene gives as `material.law`
LAWS: Mapping[str, type[LawKeys]] = MappingProxyType(_registered)


def register_law(name: str) -> Callable[[L], L]:
    """Decorator of a dataclass derived from `Law`: scenes know it as `material.law = name`, its fields are the keys of [law].

    Raises
    ------
    ValueError
        For a name that is taken or no string, or a class that is no such dataclass.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> import numpy as np
    >>> from cohesive import Law, register_law
    >>> @register_law("springs")
    ... @dataclass(frozen=True)
    ... class Springs(Law):
    ...     k: float = 1000.0
    ...
    ...     def stiffness(self, components):
    ...         return np.full(components, self.k)
    ...
    ...     def update(self, jump, history, frozen=False):
    ...         tangent = self.k * np.eye(jump.shape[1])
    ...         return self.k * jump, np.broadcast_to(tangent, (len(jump), *tangent.shape)), history
    ...
    ...     def stored_energy(self, jump, history):
    ...         return 0.5 * self.k * (jump**2).sum(axis=1)
    >>> Springs(500.0).update(np.array([[0.01, 0.0]]), np.zeros(1))[0]
    array([[5., 0.]])
    """
    if not isinstance(name, str) or not name:
        raise ValueError(f'register_law({name!r}): expected the name of the law, @register_law("name")')

    def register(cls: L) -> L:
        taken = _registered.get(name)
        if taken is not None and (taken.__module__, taken.__qualname__) != (cls.__module__, cls.__qualname__):
            raise ValueError(f"register_law({name!r}): {taken.__qualname__} has this name; expected another one")
        if not (isinstance(cls, type) and is_dataclass(cls) and issubclass(cls, LawKeys)):
            raise ValueError(f"register_law({name!r}): {cls!r} is no dataclass derived from Law")
        _registered[name] = cls
        return cls

    return register
