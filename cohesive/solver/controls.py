"""Controls: the quantity that a stage prescribes, and the equation that it adds to those of equilibrium.

A user's control is a subclass of `Control`, or of `LinearControl`, under a name that stages then know:

    @register_control("closing")
    class Closing(LinearControl):
        def row(self, problem):
            return -problem.measures["opening"]
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ..arrays import Array

if TYPE_CHECKING:
    from .problem import Guess, Problem, State

T = TypeVar("T", bound="Control | type[Control]")


@dataclass(frozen=True)
class Equation:
    """What a control asks of an iterate: gap = 0.

    Attributes
    ----------
    gap : value less target, in the unit of the control.
    row : (n,) array, derivative of the gap in the unknowns.
    corner : derivative of the gap in the load.
    """

    gap: float
    row: Array
    corner: float = 0.0


class Control(ABC):
    """A quantity that a stage prescribes.

    Attributes
    ----------
    is_motion : whether it is a motion, mm; a motion that fails to advance is followed back by dissipation.
    can_fall : whether its value may become smaller; if not, targets grow and there is no unloading.
    begins_at_onset : whether it says nothing as long as no point stands where it is damaged further. The first step then
        goes to the onset of damage instead of the target.
    advice : what helps if its steps fail, a sentence without its full stop.
    """

    is_motion: bool = False
    can_fall: bool = True
    begins_at_onset: bool = False
    advice: str = "Where part of the crack snaps through, another control or mesh.crack_size helps; smaller steps do not"

    @abstractmethod
    def value(self, problem: Problem, state: State) -> float:
        """Its value in a committed state."""

    @abstractmethod
    def equation(self, problem: Problem, target: float, start: State, now: Guess) -> Equation:
        """Its equation at an iterate `now` of the step from the committed state `start`."""

    def is_unloading(self, state: State, direction: float) -> bool:
        """Whether a step from `state` up (direction 1) or down (-1) unloads, though it does not turn back."""
        return False

    def most(self, dissipation: float) -> float:
        """Largest value that it can take if the cracks can dissipate so much in all, N mm."""
        return float(np.inf)


class LinearControl(Control):
    """A motion that is linear in the unknowns."""

    is_motion = True

    @abstractmethod
    def row(self, problem: Problem) -> Array:
        """(n,) array, the value is row @ v, mm."""

    def value(self, problem: Problem, state: State) -> float:
        return problem.motion(self.row(problem), state)

    def equation(self, problem: Problem, target: float, start: State, now: Guess) -> Equation:
        row = self.row(problem)
        return Equation(problem.motion(row, now) - target, row)


#: controls of every body, by the names that stages give them
CONTROLS: dict[str, Control] = {}


def register_control(name: str) -> Callable[[T], T]:
    """Decorate a subclass of `Control` that takes no arguments, or pass an instance: stages know it by this name.

    Raises
    ------
    ValueError
        If the name is taken.
    TypeError
        If it is no Control.
    """

    def register(control: T) -> T:
        if name in CONTROLS:
            raise ValueError(f"register_control({name!r}): there is a control of this name; expected another name")
        made = control() if isinstance(control, type) else control
        if not isinstance(made, Control):
            raise TypeError(f"register_control({name!r}) got {control!r}: expected a subclass of Control, or an instance")
        CONTROLS[name] = made
        return control

    return register


@dataclass(frozen=True)
class GaugeControl(LinearControl):
    """A measure of the problem, such as the opening of the gauge."""

    measure: str

    def row(self, problem: Problem) -> Array:
        return problem.measures[self.measure]


register_control("opening")(GaugeControl("opening"))
register_control("sliding")(GaugeControl("sliding"))


def control_of(name: str) -> Control:
    """The control of a name: a registered one, or the motion that a further gauge of the specimen measures."""
    return CONTROLS.get(name) or GaugeControl(name)


@register_control("load")
class Load(Control):
    """The load, N."""

    advice = "No larger load may be in equilibrium; control = 'opening' or 'driven' goes on past the peak"

    def value(self, problem: Problem, state: State) -> float:
        return state.load

    def equation(self, problem: Problem, target: float, start: State, now: Guess) -> Equation:
        return Equation(now.load - target, np.zeros_like(now.v), 1.0)

    def is_unloading(self, state: State, direction: float) -> bool:
        return state.load * direction < 0


@register_control("driven")
class Driven(LinearControl):
    """The motion of the drives along their direction, mm."""

    def row(self, problem: Problem) -> Array:
        return problem.drive


@register_control("dissipation")
class Dissipation(Control):
    """The energy that damage has dissipated so far, N mm."""

    can_fall = False
    begins_at_onset = True

    def value(self, problem: Problem, state: State) -> float:
        return state.dissipated

    def equation(self, problem: Problem, target: float, start: State, now: Guess) -> Equation:
        increment, gradient = problem.point_law.dissipation(start.cracks, now.cracks)
        total = start.dissipated + float(problem.operator.weights @ increment)
        return Equation(total - target, problem.operator.force(gradient))

    def most(self, dissipation: float) -> float:
        return dissipation
