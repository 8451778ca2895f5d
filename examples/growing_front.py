"""A crack front that grows inside the body: a penny-shaped notch that is pulled open, and the bowed front of a beam.

A disc of 500 mm radius in a block of concrete is open from the beginning, as a flaw in the lift joint of a dam; around it,
up to twice its radius, lie interface elements. The block is pulled at right angles, led by the mean opening of these. Linear
elastic fracture mechanics has K = 2 sigma sqrt(c / pi) for a penny of radius c in an infinite body, so that it grows at
sigma = sqrt(pi E' Gf / (4 c)), E' = E / (1 - nu^2). Here c is the radius of equal energy, sqrt(a^2 + D / (pi Gf)) with the
dissipation D; the front is the line where half of the strength is gone, at an opening of ln(2) Gf / ft. Two things part the
block from LEFM, and each is varied: the cohesive zone, by E Gf / ft^2 = a/2, 0.7 a and a, and the finite block, by its side
of 8 a or 5 a.

The beam is the built-in scene `notched-beam-3d` with a finer mesh. Its faces are free, which relieves the crack there:
the front bows. Beside the front itself the leading edge of the cohesive zone is drawn, at an opening of 1 µm.

Expected: the stress falls as the penny grows. At 1.4 a it is 0.91, 0.87, 0.84 of that of LEFM, the nearer the more brittle;
2 % are the block's doing. The front of the penny is round within an element size. That of the beam is up to a quarter of a
millimetre ahead in the middle, and its leading edge 0.7 mm, which is half an element: with nu = 0.2 the faces matter little.

    python -m examples.growing_front [-o DIR]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.tri import Triangulation
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from cohesive.figures.solid import outer_faces
from examples.command import command

Array = NDArray[np.float64]

#: of the notch, mm; radius of the disc of interfaces and side of the block in units of it
RADIUS, REACH, BLOCK, SMALL_BLOCK = 500.0, 2.0, 8.0, 5.0
#: MPa; E Gf / ft^2 is 250, 350 and 500 mm with these Gf, N/mm
E, NU, FT = 30000.0, 0.2, 3.0
ENERGIES = (0.075, 0.105, 0.15)
#: the crack grows to this radius of equal energy, in units of the notch
GROWN = 1.4
#: radii at which stresses are compared, likewise
COMPARED = (1.2, 1.3, 1.4)
#: openings at which the front of the beam is drawn, mm
OPENINGS = (0.02, 0.03, 0.05, 0.08, 0.12, 0.18)
#: opening at the leading edge of the cohesive zone, mm: with ft = 3.4 MPa and Gf = 0.07 N/mm 5 % of the strength are gone
EDGE = 1e-3


def penny(size: float, Gf: float, block: float, steps: int) -> Scene:
    """The block with its notch; element size in mm, its side in units of the radius of the notch."""
    side = block * RADIUS
    dissipated = Gf * np.pi * RADIUS**2 * (GROWN**2 - 1.0)
    return Scene(
        {
            "title": "A penny-shaped notch that grows",
            "specimen": {
                "kind": "single-crack-3d", "width": side, "height": side, "thickness": side,
                "crack_radius": REACH * RADIUS, "notch_radius": RADIUS,
            },
            "mesh": {"crack_size": size, "far_size": 8.0 * size},
            "material": {"E": E, "nu": NU, "ft": FT, "Gf": Gf},
            "stage": [{"control": "opening", "to": Gf / FT, "steps": steps, "until": {"dissipated": dissipated}}],
        }
    )  # fmt: skip


def brittle_stress(radius: Array | float, Gf: float) -> Array:
    """Stress at which a penny-shaped crack grows in an infinite brittle body, MPa."""
    return np.asarray(np.sqrt(np.pi * E / (1.0 - NU**2) * Gf / (4.0 * np.asarray(radius))))


@dataclass(frozen=True)
class Growth:
    """A run of the block.

    Attributes
    ----------
    Gf : N/mm
    radius, stress : radius of equal energy (mm) and mean stress on the block (MPa), row by row
    balance : error of the energy balance
    cost : iterations and unknowns, in words
    """

    Gf: float
    radius: Array
    stress: Array
    balance: float
    cost: str

    def over_brittle(self, radius: float) -> float:
        """Stress over that of LEFM at a radius of equal energy."""
        return float(np.interp(radius, self.radius, self.stress) / brittle_stress(radius, self.Gf))


def grow(scene: Scene) -> tuple[Growth, Result]:
    """Run the block. Its result holds a factor of the whole body; what is compared does not."""
    result = run(scene)
    h, Gf = result.history, scene.material.Gf
    radius = np.sqrt(RADIUS**2 + h["dissipated"] / (np.pi * Gf))
    cost = f"{result.iterations} iterations, {result.active_dofs} of {result.total_dofs} unknowns"
    area = scene.specimen.width**2  # type: ignore[attr-defined]
    return Growth(Gf, radius, h["load"] / area, result.energy_error, cost), result


def openings(result: Result, row: int, axes: tuple[int, int]) -> tuple[Triangulation, Array]:
    """The crack plane as triangles between its points, in two of the coordinates, and the opening at these points, mm."""
    where, opening = result.opening_profile(row)
    points, index = np.unique(where[:, axes].round(6), axis=0, return_inverse=True)
    index = index.ravel()
    mean = np.bincount(index, opening) / np.bincount(index)
    triangles = Triangulation(*points.T)
    return triangles, mean


def front(triangles: Triangulation, opening: Array, level: float) -> Array:
    """Where the edges of the triangles meet an opening, (n, 2)."""
    points = np.column_stack([triangles.x, triangles.y])
    first, second = (opening[triangles.edges[:, i]] - level for i in (0, 1))
    cut = first * second < 0
    share = (first[cut] / (first[cut] - second[cut]))[:, None]
    a, b = (points[triangles.edges[cut, i]] for i in (0, 1))
    return np.asarray(a + share * (b - a))


def half_strength(result: Result) -> float:
    """Opening at which half of the strength is gone, mm: the softening curve is an exponential."""
    return float(np.log(2.0) * result.scene.material.Gf / result.scene.material.ft)


def penny_front(result: Result, row: int) -> Array:
    """Points (n, 2) of the front of the penny in a row of the history; of none where it has not left the notch."""
    triangles, opening = openings(result, row, (2, 0))
    middle = np.hypot(triangles.x[triangles.triangles].mean(axis=1), triangles.y[triangles.triangles].mean(axis=1))
    triangles.set_mask(middle < 0.98 * RADIUS)
    return front(triangles, opening, half_strength(result))


def main(
    size: float = 100.0,
    steps: int = 40,
    energies: Sequence[float] = ENERGIES,
    beam_size: float = 1.5,
    layers: int = 10,
    plot: Path | None = None,
) -> dict[str, float]:
    """Let both fronts grow; print and return the numbers.

    Parameters
    ----------
    size : element size on the crack of the block, mm.
    steps : to a mean opening of Gf / ft, which is not reached.
    energies : Gf, N/mm; with the first one the block is varied too.
    beam_size : element size along the crack of the beam, mm.
    layers : through its thickness.
    plot : file for the figure.
    """
    numbers: dict[str, float] = {}
    brittle, result = grow(penny(size, energies[0], BLOCK, steps))
    cases = {(energies[0], BLOCK): brittle}
    for Gf, block in (*((Gf, BLOCK) for Gf in energies[1:]), (energies[0], SMALL_BLOCK)):
        cases[Gf, block], _ = grow(penny(size, Gf, block, steps))
    print("stress over that of LEFM at radii of equal energy c; largest stress, over LEFM of the notch, at c/a")
    print(f"{'':44s}" + "".join(f"{c:6.1f} a" for c in COMPARED))
    for (Gf, block), one in cases.items():
        name = _name(Gf, block)
        ratios = [one.over_brittle(c * RADIUS) for c in COMPARED]
        peak = int(one.stress.argmax())
        highest = float(one.stress[peak] / brittle_stress(RADIUS, Gf))
        numbers |= {f"{name}: at {c:g} a": ratio for c, ratio in zip(COMPARED, ratios, strict=True)}
        numbers |= {f"{name}: peak": highest, f"{name}: balance": one.balance}
        print(f"    {name:40s}" + "".join(f"{ratio:8.3f}" for ratio in ratios)
              + f"{one.stress[peak]:11.3f} MPa {highest:6.3f} {one.radius[peak] / RADIUS:6.2f}"
              + f"   {one.cost}")  # fmt: skip
    small, large = (numbers[f"{_name(energies[0], block)}: at {GROWN:g} a"] for block in (SMALL_BLOCK, BLOCK))
    # what a penny adds to the body's compliance goes with its volume
    lost = (large - small) / ((BLOCK / SMALL_BLOCK) ** 3 - 1.0)
    numbers["lost to the block"] = lost
    print(f"the block of {BLOCK:g} a takes about {100 * lost:.1f} % off at {GROWN:g} a, if that falls with its volume")
    rows = [int(abs(brittle.radius - c * RADIUS).argmin()) for c in np.linspace(1.1, GROWN, 5)]
    h = result.history
    print("penny: load (N), dissipated, elastic energy (N mm), radius of equal energy, of the front (mm), spread in elements")
    for i, row in enumerate(rows):
        radii = np.hypot(*penny_front(result, row).T)
        spread = float(np.ptp(radii) / size)
        numbers |= {f"penny {i}: radius": float(radii.mean()), f"penny {i}: of equal energy": float(brittle.radius[row])}
        numbers[f"penny {i}: spread"] = spread
        print(f"    {h['load'][row]:10.4g}{h['dissipated'][row]:11.4g}{h['elastic'][row]:11.4g}"
              f"{brittle.radius[row]:9.1f}{radii.mean():9.1f}{spread:7.2f}")  # fmt: skip

    beam = run(
        Scene.load("notched-beam-3d").with_(**{"mesh.crack_size": beam_size, "mesh.layers": layers, "output.frames": 0})
    )
    h = beam.history
    shown = [int(abs(h["opening"] - opening).argmin()) for opening in OPENINGS]
    ahead = {level: np.array([bow(beam_front(beam, row, level)) for row in range(len(h["step"]))])
             for level in (half_strength(beam), EDGE)}  # fmt: skip
    print("beam: opening (mm), load (N), dissipated, elastic energy (N mm); front and leading edge: height in the middle, how "
          "far that is ahead of the faces (mm)")  # fmt: skip
    for row in shown:
        opening = f"{h['opening'][row]:.2f}"
        numbers[f"beam at {opening}: front ahead"], numbers[f"beam at {opening}: edge ahead"] = (
            a[row, 1] for a in ahead.values()
        )
        print(f"    {h['opening'][row]:6.3f}{h['load'][row]:9.1f}{h['dissipated'][row]:9.2f}{h['elastic'][row]:9.2f}"
              + "".join(f"{height:9.2f}{first:7.2f}" for height, first in (a[row] for a in ahead.values())))  # fmt: skip
    if plot is not None:
        _draw(cases, result, rows, beam, shown, ahead, plot)
    return numbers


def _name(Gf: float, block: float) -> str:
    return f"E Gf / ft^2 = {E * Gf / FT**2 / RADIUS:g} a, block of {block:g} a"


def beam_front(result: Result, row: int, level: float) -> Array:
    """Points (z, y) of the beam in a row of the history where the opening passes a level."""
    return front(*openings(result, row, (2, 1)), level)


def bow(points: Array) -> tuple[float, float]:
    """Height of a front in the middle, and how far it is ahead of that at the faces; NaN where there is none."""
    if not len(points):
        return np.nan, np.nan
    z = abs(points[:, 0])
    middle, face = (float(points[at, 1].mean()) for at in (z < z.min() + 1e-6, z > z.max() - 1e-6))
    return middle, middle - face


def _draw(
    cases: dict[tuple[float, float], Growth],
    result: Result,
    rows: Sequence[int],
    beam: Result,
    shown: Sequence[int],
    ahead: dict[float, Array],
    path: Path,
) -> None:
    figure = new_figure(13.0, 8.0)
    grid = figure.add_gridspec(2, 6, height_ratios=(1.25, 1.0))
    plane, stress = figure.add_subplot(grid[0, :2]), figure.add_subplot(grid[0, 2:4])
    across, bowed = figure.add_subplot(grid[1, :3]), figure.add_subplot(grid[1, 3:])
    brittle, *_ = cases.values()
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    for radius, style, label in ((RADIUS, "k-", "notch"), (REACH * RADIUS, "k:", "end of the interfaces")):
        plane.plot(radius * np.cos(turn), radius * np.sin(turn), style, linewidth=0.8, label=label)
    for i, row in enumerate(rows):
        around = penny_front(result, row)
        around = around[np.argsort(np.arctan2(around[:, 1], around[:, 0]))]
        plane.plot(*np.append(around, around[:1], axis=0).T, color=f"C{i}")
        stress.plot(brittle.radius[row] / RADIUS, brittle.stress[row] / brittle_stress(RADIUS, brittle.Gf), "o", color=f"C{i}")
    plane.set_aspect("equal")
    plane.set(xlabel="z (mm)", ylabel="x (mm)", title="front of the penny (colours: see right)", ylim=(-1050, 1400))
    for (Gf, block), one in cases.items():
        style, grey = "-" if block == BLOCK else "--", 0.6 * (Gf / brittle.Gf - 1.0)
        name = f"$E G_f / f_t^2$ = {E * Gf / FT**2 / RADIUS:g} a, block of {block:g} a"
        x, y = one.radius / RADIUS, one.stress / brittle_stress(RADIUS, Gf)
        stress.plot(x, y, style, color=str(grey), label=name, zorder=1)
    c = np.linspace(1.0, GROWN, 50)
    stress.plot(c, c**-0.5, "C3:", label="LEFM, infinite body")
    stress.set(xlabel="radius of equal energy / a", ylabel="stress over LEFM of the notch", ylim=(0, 1.05))
    stress.set(title="pull on the block")
    _draw_opened(figure, grid[0, 4:], result)
    h = beam.history
    for i, row in enumerate(shown):
        for level, style in zip(ahead, ("-", ":"), strict=True):
            points = beam_front(beam, row, level)
            legend = f"opening {h['opening'][row]:.3f} mm, {h['load'][row]:.0f} N" if level == EDGE else None
            across.plot(*points[np.argsort(points[:, 0])].T, style, color=f"C{i}", label=legend)
    across.set(xlabel="z, over the thickness (mm)", ylabel="y (mm)", xlim=(-25, 62), ylim=(25.0, 50.0))
    across.set(title="beam: front (full line) and leading edge of the cohesive zone")
    for (level, values), style, name in zip(ahead.items(), ("-", ":"), ("front", "leading edge"), strict=True):
        bowed.plot(h["opening"], values[:, 1], "k" + style, label=f"{name}, where the crack is open by {1e3 * level:.3g} µm")
    bowed.set(xlabel="opening (mm)", ylabel="ahead in the middle (mm)", ylim=(0.0, None), title="beam: bow")
    for axes in (plane, stress, across, bowed):
        axes.legend(frameon=False, fontsize=8)
    save(figure, path)


def _draw_opened(figure: Figure, place: SubplotSpec, result: Result) -> None:
    """Half of both crack faces in the last row, the notch included, opened up."""
    fields, frame = result.fields, result.frame(-1)
    nodes, _ = outer_faces([(block.kind, block.cells) for block in fields.bulk])
    corners, lift = fields.mesh.points[nodes], frame.displacement[nodes][..., 1] - result.history["driven"][-1] / 2
    behind = (abs(corners[..., 1]) < 1e-6).all(axis=1) & (corners[..., 2].mean(axis=1) < 0)
    corners, lift = corners[behind], lift[behind]
    factor = float(f"{0.4 * RADIUS / abs(lift).max():.0e}")
    axes = figure.add_subplot(place, projection="3d", proj_type="ortho")
    assert isinstance(axes, Axes3D)
    drawn = np.stack([corners[..., 2], corners[..., 0], factor * lift], axis=-1)
    faces = Poly3DCollection(
        list(drawn), array=2.0 * abs(lift).mean(axis=1), cmap="plasma", edgecolors=(0.0, 0.0, 0.0, 0.3), linewidths=0.2
    )
    axes.add_collection3d(faces)
    reach = REACH * RADIUS
    axes.set(xlim=(-reach, 0.0), ylim=(-reach, reach), zlim=(-0.5 * RADIUS, 0.5 * RADIUS), xlabel="z (mm)", ylabel="x (mm)")
    axes.set_box_aspect((1.0, 2.0, 0.5), zoom=1.1)
    axes.set(xticks=[-1000, -500, 0], zticks=[])
    axes.view_init(20.0, 25.0)
    axes.set_title(f"the opened penny, cut in half ({factor:.0f} times)")
    figure.colorbar(faces, ax=axes, label="opening (mm)", orientation="horizontal", shrink=0.7, pad=0.0)


if __name__ == "__main__":
    command(main, __doc__, "growing_front.png")
