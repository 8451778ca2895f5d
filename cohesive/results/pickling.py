"""What a pickled result carries of its model: all but the stiffness and its factors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ..arrays import Array

if TYPE_CHECKING:
    from ..model.model import Model

_NOT_CARRIED = "a result from a pickle does not carry the stiffness of its body; run its scene again to solve with it"


@dataclass(frozen=True)
class Released:
    """Stands in place of the stiffness.

    Attributes
    ----------
    library : what solved the linear systems
    """

    library: str

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"{name}: {_NOT_CARRIED}")


def without_factors(model: Model) -> Model:
    """The same model without stiffness, factors and recovery, which may be large and hold objects that cannot be pickled."""
    released: Any = Released(model.library)
    return replace(
        model,
        problem=replace(model.problem, stiffness=released),
        condensation=replace(model.condensation, stiffness=released, recover=_recover),
    )


def _recover(v: Array) -> Array:
    raise RuntimeError(_NOT_CARRIED)
