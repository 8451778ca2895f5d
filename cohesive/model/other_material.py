"""The same meshed and condensed body of another material: what fits and searches stand on."""

from __future__ import annotations

from dataclasses import replace

from ..law.concrete import Concrete
from ..law.crack_plane import CrackPlane
from .interface import InterfacePart
from .model import Model


def with_material(model: Model, old: Concrete, new: Concrete) -> Model | None:
    """A discrete model with another material, on the same mesh and with the same width of the crack plane.

    The condensed stiffness does not depend on the law, and is proportional to E if the bulk is one material.

    Parameters
    ----------
    old : that of the model.

    Returns
    -------
    Model, or None if it has to be built anew: with another Poisson's ratio or density, with dead loads, or another E beside
    regions with constants of their own, or if PETSc holds the stiffness.
    """
    part, problem = model.cracks, model.problem
    if not isinstance(part, InterfacePart) or problem.dead_factor or (new.nu, new.density) != (old.nu, old.density):
        return None
    condensation = model.condensation
    if new.E != old.E:
        has_regions = any(region.any() for region in model.mesh.regions)
        if has_regions or not hasattr(condensation.stiffness, "scaled"):
            return None
        condensation = replace(condensation, stiffness=condensation.stiffness.scaled(new.E / old.E))
    law = replace(part.point_law, plane=CrackPlane(new, part.width))
    return replace(
        model,
        cracks=replace(part, point_law=law),
        condensation=condensation,
        problem=replace(
            problem,
            point_law=law,
            stiffness=condensation.stiffness,
            strength=problem.strength * new.ft / old.ft,
            energy=problem.energy * new.Gf / old.Gf,
        ),
    )
