"""Steps: what a run hands out, and how their sizes follow the iterations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from .newton import Equilibrium, most_iterations
from .problem import Problem

#: a step is cut down to this part of the nominal one before the crack is taken to snap
SMALLEST_STEP = 2.0**-10

#: a step that needed no more than this part of the iterations that it may take lets the next one grow back to the nominal
#: step, and one that needed no more than the second part lets it grow beyond
EASY, VERY_EASY = 0.25, 0.1


@dataclass(frozen=True)
class Step:
    """One converged step.

    Attributes
    ----------
    cuts : how often it was cut before it converged
    control, value : what was prescribed, and what it came to
    stage : number of the stage, the first is 1
    """

    equilibrium: Equilibrium
    cuts: int
    control: str
    value: float
    stage: int


class Resumable:
    """What goes on after a step where another one of its kind stood: its `moving` fields say where that is."""

    moving: ClassVar[tuple[str, ...]]

    def as_data(self) -> dict[str, Any]:
        """Where it stands, in numbers, text, arrays and data classes of them."""
        return {name: getattr(self, name) for name in self.moving}

    def go_on_from(self, data: Mapping[str, Any]) -> None:
        """Stand where another one stood that gave these `as_data`."""
        for name in self.moving:
            setattr(self, name, data[name])


def next_size(problem: Problem, size: float, iterations: int, nominal: float, growth: float = 1.0) -> float:
    """Size of the step after one, from its number of iterations.

    Parameters
    ----------
    growth : up to which multiple of the nominal step it may grow.
    """
    effort = iterations / most_iterations(problem)
    if effort > EASY:
        return max(0.5 * size, nominal) if size > nominal else size
    most = nominal * (growth if effort <= VERY_EASY else 1.0)
    return min(2.0 * size, most) if size < most else size
