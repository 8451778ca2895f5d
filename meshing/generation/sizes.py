"""Element sizes, and the checks of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..cells import CELLS, CellType
from ..errors import MeshError
from ..keys import check_keys, key

#: growth of the element size with the distance from the path
GROWTH = 0.25

#: values of the key `mesh.shape`, types of 2D cells, and the 3D cells that they stand for
SHAPES = {"triangle": "tetra", "quad": "hexahedron"}

#: more elements along a crack, or in a body, than any of these cases needs or a machine holds
_MOST_ALONG, _MOST_IN_ALL = 1e5, 2e7


@dataclass(frozen=True)
class MeshSizes:
    """How a specimen is meshed; the metadata of each field says what it means.

    Raises
    ------
    MeshError
        Naming the key, its value and what was expected.
    """

    crack_size: float = key(
        "element size along the crack path; default: the smaller of 1/20 of the crack length and 1/12 of E Gf/ft^2",
        unit="mm",
        above=0,
        by_rule=True,
    )
    far_size: float = key(
        "element size far from the crack path; default: 8 times crack_size", unit="mm", above=0, by_rule=True
    )
    shape: str = key("shape of the elements; in 3D they stand for tetrahedra and hexahedra", "triangle", one_of=tuple(SHAPES))
    order: int = key(
        "order of the elements; hexahedra are of first order; default: 2 in the plane, 1 in space",
        1,
        at_least=1,
        at_most=2,
        by_rule=True,
    )
    layers: int | None = key(
        "elements through the thickness of an extruded specimen, refused by any other; default: as thick as far_size",
        None,
        at_least=1,
    )

    def __post_init__(self) -> None:
        check_keys(self, MeshError)
        for name in ("crack_size", "far_size"):
            if getattr(self, name) == math.inf:
                raise MeshError.at(name, " = inf: expected a finite number above 0, in mm")
        if self.far_size < self.crack_size:
            raise MeshError.at("far_size", f" = {self.far_size!r}: expected at least crack_size = {self.crack_size!r}")

    @property
    def has_quads(self) -> bool:
        """Whether the elements are quadrilaterals or hexahedra."""
        return self.shape == "quad"

    def cell_type(self, dimension: int) -> CellType:
        """Type of the cells of a body."""
        cell = CELLS[self.shape if dimension == 2 else SHAPES[self.shape]]
        return CELLS[cell.second_order] if self.order == 2 else cell

    def layers_through(self, thickness: float) -> int:
        """Number of elements through a thickness, mm."""
        return max(1, round(thickness / self.far_size)) if self.layers is None else self.layers


def check_sizes(sizes: MeshSizes, crack_length: float, area: float) -> None:
    """Refuse element sizes that would fill the memory.

    Parameters
    ----------
    sizes : MeshSizes
    crack_length, area : of the crack path, mm, and of the 2D body, mm^2.

    Raises
    ------
    MeshError
    """
    check_count("crack_size", sizes.crack_size, "along the crack", crack_length, 1, _MOST_ALONG)
    check_count("far_size", sizes.far_size, "in the body", area, 2, _MOST_IN_ALL)


def check_count(name: str, size: float, where: str, extent: float, dimension: int, most: float) -> None:
    """Refuse an element size that gives more than `most` elements in a length, area or volume; MeshError."""
    if (count := extent / size**dimension) > most:
        least = (extent / most) ** (1 / dimension)
        raise MeshError.at(f"mesh.{name}", f" = {size:g}: {count:.2g} elements {where}; expected at least {least:.2g} mm")


def expected_cells(sizes: MeshSizes, extent: float, path: float, dimension: int) -> float:
    """About how many squares, or cubes, of the sizes fill a body: those around the path, as they grow, and those far from it.

    Parameters
    ----------
    extent : area of the body, mm^2, or its volume, mm^3.
    path : length of the crack path, mm, or its area, mm^2.
    """
    near, far = sizes.crack_size, sizes.far_size
    reach = min((far - near) / GROWTH, 0.5 * extent / path) if path else 0.0  # from the path to where they are large
    last = near + GROWTH * reach
    around = 2.0 * path / GROWTH * (near ** (1 - dimension) - last ** (1 - dimension)) / (dimension - 1)
    if path and dimension == 2:  # beyond an end of the path, in half a circle
        around += math.pi / GROWTH**2 * (math.log(last / near) + near / last - 1.0)
    return around + max(extent - 2.0 * path * reach, 0.0) / far**dimension


def check_not_layered(sizes: MeshSizes) -> None:
    """Refuse layers; MeshError."""
    if sizes.layers is not None:
        raise MeshError.at(
            "mesh.layers", f" = {sizes.layers!r}: this specimen is not extruded over a thickness; expected no such key"
        )
