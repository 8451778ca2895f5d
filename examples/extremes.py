"""How far do the models hold? Seventeen maps of extremes: converged, cut, led on, failed, refused, and why.

Each map drives one quantity through its extremes, in both models, and where faces close also with the corrected contact
(`material.contact = "potential"`). Every run writes its history while it goes on; a map counts as failed whatever leaves
no history, or one that is not finite.

Expected: no exception but the named ones. The printed contact fails where it is stiffer than the concrete around it, in a
crack band that is closed by more than a few MPa and all the more the nearer nu is to 0.5; the corrected one does not. A crack
that snaps back under its platen is followed by its dissipation. Closed loops of opening and shear create or destroy energy
in the printed form, none in the corrected one.

    python -m examples.extremes [-o DIR]

About five minutes on two cores; extremes.csv has a line for each run.
"""

from __future__ import annotations

import multiprocessing
import os
import re
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from matplotlib.patches import Patch, Rectangle
from tqdm import tqdm

from cohesive import Concrete, NotConverged, Result, Scene, SceneError, run
from cohesive.figures.drawing import new_figure, save
from cohesive.results.files import write_table
from examples.command import command
from meshing import MeshError

BOTH = ("discrete", "smeared")
FOUR = ("discrete", "discrete, corrected", "smeared", "smeared, corrected")
COLOURS = {
    "converged": "#7fb77e", "cut": "#d9d26a", "led on": "#e8a857", "failed": "#d16d6a", "refused": "#b9b9b9",
}  # fmt: skip
#: what the colours stand for
MEANING = {
    "converged": "converged", "cut": "converged, some steps cut", "led on": "led on by dissipation or damping, and says so",
    "failed": "stopped with a named reason, history saved", "refused": "refused before the first step",
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """One run: the map it belongs to, its place there, the changes to the scene, and what is read off its result."""

    map: str
    row: str
    value: str
    scene: Scene
    read: Callable[[Result], str]


@dataclass(frozen=True)
class Outcome:
    """What became of a run: a key of `COLOURS`, the reason, what was read off; steps, iterations, cuts, seconds."""

    status: str
    reason: str
    text: str
    steps: int = 0
    iterations: int = 0
    cuts: int = 0
    seconds: float = 0.0


def outcome(case: Case) -> Outcome:
    """Run one case; every exception but the named ones is passed on."""
    clock, reason = time.perf_counter(), ""
    with tempfile.TemporaryDirectory() as folder:
        try:
            result = run(case.scene, output=folder)
        except (SceneError, MeshError) as error:
            return Outcome("refused", str(error), "", seconds=time.perf_counter() - clock)
        except NotConverged as error:
            assert isinstance(error.result, Result)
            result, reason = error.result, str(error)
        rows = np.loadtxt(Path(folder, "history.csv"), delimiter=",", skiprows=1, ndmin=2)
    h = result.history
    finite = np.isfinite(rows[:, [name != "effective_length" for name in h]]).all()  # a length that not every body has
    if len(rows) != len(h["step"]) or not finite:
        raise RuntimeError(f"{case}: history.csv has {len(rows)} rows of {len(h['step'])}, finite: {finite}")
    led = [note for note in result.notes if re.search("snaps at|goes back", note)]
    cuts = int(h["cuts"].sum())
    status = "failed" if reason else "led on" if led else "cut" if cuts else "converged"
    text = case.read(result) if result.steps else ""
    seconds = time.perf_counter() - clock
    return Outcome(status, reason or "; ".join(led), text, result.steps, result.iterations, cuts, seconds)


# -- what is read off -----------------------------------------------------------------------------------------------------


def iterations(result: Result) -> str:
    return f"{result.iterations}"


def peak(result: Result) -> str:
    return f"{result.peak_load:.0f} N"


def stress(result: Result) -> str:
    """Least normal stress reached."""
    return f"{result.history['stress_n'].min():.2g}"


def shear(result: Result) -> str:
    """Largest shear stress over ft."""
    return f"{abs(result.history['stress_s']).max() / result.scene.material.ft:.2g} ft"


def dissipated(result: Result) -> str:
    """Part of what the crack can dissipate in opening."""
    assert result.full_energy is not None
    return f"{100 * result.dissipated_energy / result.full_energy:.0f} %"


def drift(result: Result) -> str:
    """Largest change of the stress between the first cycle's largest opening and those of the others, over ft."""
    h = result.history
    at_top = h["stress_n"][h["opening"] > 0.999 * h["opening"].max()]
    return f"{np.ptp(at_top[1:]) / result.scene.material.ft:.0e}"


def loop(result: Result) -> str:
    """Work of the contact in the last loop, over Gf."""
    h = result.history
    last = h["stage"] > h["stage"].max() - 4
    start = np.flatnonzero(last)[0] - 1
    work = h["work"] - h["elastic"] - h["stored"] - h["dissipated"]
    return f"{(work[-1] - work[start]) / (result.scene.material.Gf * result.facts.crack_area):+.2f}"


def against(scale: float, base: Scene, result: Result) -> str:
    """Largest difference of the loads from those in N and mm, over the peak."""
    other = run(base).history["load"]
    return f"{abs(result.history['load'] / scale - other).max() / other.max():.0e}"


# -- scenes ---------------------------------------------------------------------------------------------------------------


def beam(**changes: Any) -> Scene:
    """The notched beam on a coarse mesh; `changes` with __ for the dots of the keys."""
    scene = Scene.load("notched-beam").with_(**{"mesh.crack_size": 2.5, "mesh.far_size": 10.0, "stage.0.steps": 30})
    return scene.with_(**{key.replace("__", "."): value for key, value in changes.items()})


def block(stages: Sequence[dict[str, Any]], **changes: Any) -> Scene:
    """A block of 40 x 40 x 10 mm with a crack through it."""
    data: dict[str, Any] = {
        "title": "block",
        "specimen": {"kind": "single-crack", "width": 40.0, "height": 40.0, "thickness": 10.0},
        "mesh": {"crack_size": 5.0, "far_size": 10.0},
        "material": {"preset": "reinhardt"},
        "stage": list(stages),
    }
    return Scene(data).with_(**{key.replace("__", "."): value for key, value in changes.items()})


def rows(names: Sequence[str], scene: Scene) -> Iterator[tuple[str, Scene]]:
    """The same scene in some of `FOUR`."""
    for name in names:
        contact = "potential" if name.endswith("corrected") else "printed"
        yield name, scene.with_(**{"model.kind": name.split(",")[0], "material.contact": contact})


def grid(folder: Path, name: str, height: float = 5.0, bend: float = 0.0, length: float = 1.0, force: float = 1.0) -> Scene:
    """A block of 8 x 8 quadrilaterals of 5 mm by `height` with a crack, or a band, in its middle, pulled at half its top.

    `bend` moves the nodes beside the crack at random by that part of an element. `length` and `force` are the units, so many
    to a millimetre and to a newton.
    """
    random = np.random.default_rng(1)
    x, y = (a.ravel() for a in np.meshgrid(5.0 * np.arange(9), height * np.arange(9)))
    inside = (x > 0) & (x < 40) & (y > 0) & (y < 8 * height) & ((y < 3.5 * height) | (y > 5.5 * height))
    move = bend * random.uniform(-1, 1, (2, x.size)) * inside
    points = np.column_stack([x + 5.0 * move[0], y + height * move[1], 0 * x])
    i, j = (a.ravel() for a in np.meshgrid(np.arange(8), np.arange(8)))
    cells = 9 * j[:, None] + i[:, None] + np.array([0, 1, 10, 9])
    path = folder / f"{name}.inp"
    meshio.write(path, meshio.Mesh(length * points, [("quad", cells)]))
    sets = {"BASE": y == 0, "PULLED": (y == 8 * height) & (x >= 20), "CRACK": y == 4 * height}
    text = "".join(f"*NSET, NSET={key}\n{','.join(map(str, np.flatnonzero(at) + 1))}\n" for key, at in sets.items())
    text += f"*ELSET, ELSET=BAND\n{','.join(map(str, np.flatnonzero(j == 4) + 1))}\n"
    path.write_text(path.read_text() + text)
    m = Concrete.preset("reinhardt")
    data = {
        "title": "grid",
        "specimen": {
            "kind": "mesh", "file": str(path), "thickness": 10.0 * length, "crack": "CRACK", "band": "BAND",
            "supports": [{"at": "BASE", "direction": [0, 1]}, {"at": [0, 0], "direction": [1, 0]}],
            "drive": {"at": "PULLED", "direction": [0, 1]},
        },
        "material": {
            "preset": "reinhardt", "E": m.E * force / length**2, "ft": m.ft * force / length**2, "Gf": m.Gf * force / length,
            "h": m.h * length, "unusual": True,
        },
        "stage": [{"control": "opening", "to": 0.1 * length, "steps": 30}],
    }  # fmt: skip
    return Scene(data)


def cases(folder: Path, thorough: bool) -> Iterator[Case]:
    """All runs; meshes are written to `folder`."""

    def each(title: str, names: Sequence[str], read: Callable[[Result], str], scenes: dict[str, Scene]) -> Iterator[Case]:
        for value, scene in scenes.items():
            for row, changed in rows(names, scene):
                yield Case(title, row, value, changed, read)

    def some(values: Sequence[float]) -> Sequence[float]:
        return values if thorough else values[:: len(values) - 1]

    there_and_back = [{"control": "driven", "to": [0.06, -0.01], "steps": 20}]
    inclined = block(there_and_back, specimen__angle=20.0, specimen__faces="clamped")
    smoothing = {f"{c:g}": inclined.with_(**{"material.c_zn": c}) for c in some((3.1, 5.0, 9.0, 20.0, 100.0, 1000.0))}
    smoothing["off"] = inclined.with_(**{"material.c_zn": 1e9, "material.r_z": 0.0})
    yield from each("smoothing c_zn, opened and closed", FOUR, iterations, smoothing)

    counts = some((1, 2, 5, 10, 30, 100, 300, 1000))
    yield from each("steps over one history", BOTH, peak, {f"{n}": beam(stage__0__steps=int(n)) for n in counts})

    def slam(pressure: float, plane: str, nu: float) -> Scene:
        stages = [
            {"control": "opening", "to": 0.1, "steps": 20},
            {"control": "load", "to": -pressure * 400.0, "steps": 1},
        ]
        return block(stages, model__plane=plane, material__nu=nu)

    pressures = some((1.0, 3.0, 10.0, 30.0, 100.0))
    yield from each("opened by 0.1 mm, slammed to -p (MPa), plane stress", FOUR, iterations,
                    {f"{p:g}": slam(p, "stress", 0.2) for p in pressures})  # fmt: skip
    yield from each("the same, plane strain", FOUR, iterations, {f"{p:g}": slam(p, "strain", 0.2) for p in pressures})
    ratios = some((0.0, 0.2, 0.3, 0.4, 0.49, 0.4999))
    yield from each("to -10 MPa in plane strain, nu", FOUR, iterations, {f"{nu:g}": slam(10.0, "strain", nu) for nu in ratios})

    def cycles(n: int) -> Scene:
        stage = {"control": "opening", "to": [0.05, *(0.001, 0.05) * n], "steps": 2}
        return block([stage], mesh__crack_size=40.0, mesh__far_size=40.0, band__width=5.0)

    yield from each("opened and closed n times: drift / ft", FOUR, drift,
                    {f"{n}": cycles(int(n)) for n in ((10, 100, 1000) if thorough else (2, 4))})  # fmt: skip

    openings = {f"{n:g}": beam(stage__0__to=0.103 * n) for n in some((0.1, 1.0, 3.0, 10.0, 30.0, 100.0))}
    yield from each("opening in Zm: energy spent", BOTH, dissipated, openings)

    bar = block([{"control": "driven", "to": 0.2, "steps": 40}], specimen__height=600.0, mesh__far_size=40.0)
    brittle = {f"{f:g}": bar.with_(**{"material.Gf": 0.12 * f}) for f in some((0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0))}
    yield from each("bar of 600 mm under its platen, Gf x", BOTH, iterations, brittle)

    widths = {f"{w:g}": beam(interface__width=w, band__width=w) for w in some((0.01, 0.1, 0.5, 2.5, 10.0, 20.0, 60.0))}
    yield from each("width of the crack plane (mm)", BOTH, peak, widths)

    tough = beam(material__Gf=0.2, stage__0__to=0.5)
    sizes = {
        f"{s:g}": tough.with_(**{"mesh.crack_size": s, "mesh.far_size": max(8.0, s), "band.width": min(s, 2.5)})
        for s in some((0.3, 0.5, 1.0, 2.5, 5.0, 12.5, 25.0))
    }
    yield from each("crack size (mm): from Zm to one element", BOTH, peak, sizes)

    units = {"mm, N": (1.0, 1.0), "m, N": (1e-3, 1.0), "MPa x 1e-6": (1.0, 1e-6), "MPa x 1e9": (1.0, 1e9)}
    for value, (length, force) in units.items():
        scenes = [grid(folder, f"units-{u:g}", length=u, force=f) for u, f in ((length, force), (1.0, 1.0))]
        for row in BOTH:
            scene, base = (scene.with_(**{"model.kind": row}) for scene in scenes)
            yield Case("units: difference of the curves", row, value, scene, partial(against, force, base))

    aspects = {f"{a:g}": grid(folder, f"aspect-{a:g}", height=5.0 / a) for a in some((1.0, 10.0, 100.0, 1000.0))}
    yield from each("elements so many times as long as high", BOTH, peak, aspects)
    bent = {f"{b:g}": grid(folder, f"bent-{b:g}", bend=b) for b in some((0.0, 0.2, 0.4, 0.45, 0.5, 0.6))}
    yield from each("nodes moved at random, part of an element", BOTH, peak, bent)

    def plate(*stages: dict[str, Any]) -> Scene:
        scene = Scene.load("jacobsen-mixed-mode").with_(**{"mesh.crack_size": 5.0, "mesh.far_size": 10.0})
        return scene.with_(stage=list(stages))

    sheared = {
        name: plate({"control": "driven", "angle": 90.0, "hold": hold, "to": 0.2, "steps": 40})
        for name, hold in (("opening free", False), ("opening held", True))
    }
    yield from each("sheared from zero", FOUR, shear, sheared)

    pressed = {f"{p:g}": block([{"control": "load", "to": -p * 400.0, "steps": 5}]) for p in some((1.0, 10.0, 100.0, 1000.0))}
    yield from each("compression only (MPa)", FOUR, stress, pressed)

    def loops(turn: int) -> Scene:
        first = [{"control": "driven", "angle": 0.0, "to": 0.15, "steps": 60}, {"control": "driven", "angle": 90.0, "to": 0.2}]
        there = [(0.0, 0.05), (90.0, 0.0), (0.0, 0.15), (90.0, 0.2)]
        back = [(90.0, 0.0), (0.0, 0.05), (90.0, 0.2), (0.0, 0.15)]
        once = [{"control": "driven", "angle": a, "to": to} for a, to in (there if turn > 0 else back)]
        return plate(*first, *once, *once)

    yield from each("closed loop of opening and shear: work / Gf", FOUR, loop,
                    {"one way": loops(1), "other way": loops(-1)})  # fmt: skip

    coarse = {"specimen__gauge": 20.0, "mesh__crack_size": 10.0, "band__where": "everywhere"}
    crossing = [[[-20.0, 0.0], [20.0, 0.0]], [[0.0, -20.0], [0.0, 20.0]]]
    pull = [{"control": "driven", "to": 1.0, "steps": 40}]
    pieces = {
        "two, pulled": block(pull, specimen__faces="clamped"),
        "two, to and fro": block([{"control": "driven", "to": [0.8, -0.01], "steps": 30}], specimen__faces="clamped"),
        "four, pulled": block(pull, specimen__faces="clamped", specimen__crack=crossing, **coarse),
        "four, sheared": block(pull, specimen__faces="clamped", specimen__crack=crossing, specimen__drive_angle=45.0,
                               **coarse),
    }  # fmt: skip
    yield from each("a body in pieces", FOUR, iterations, pieces)


def main(thorough: bool = True, plot: Path | None = None) -> dict[str, dict[str, int]]:
    """Run all maps; print and return how many runs ended in each way, by map.

    Parameters
    ----------
    thorough : all values of each map, or only its ends.
    plot : file for the figure; the table goes beside it, as .csv.
    """
    with tempfile.TemporaryDirectory() as folder:
        todo = list(cases(Path(folder), thorough))
        with ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("spawn")) as pool:
            found = list(tqdm(pool.map(outcome, todo), total=len(todo), unit="run", disable=not sys.stderr.isatty()))
    table: dict[str, dict[str, int]] = {}
    for case, end in zip(todo, found, strict=True):
        counts = table.setdefault(case.map, dict.fromkeys(COLOURS, 0))
        counts[end.status] += 1
    print(f"{'':54s}" + "".join(f"{status:>11s}" for status in COLOURS))
    for title, counts in table.items():
        print(f"{title:54s}" + "".join(f"{n or '':>11}" for n in counts.values()))
    print("\nfailed and refused:")
    for case, end in zip(todo, found, strict=True):
        if end.status in ("failed", "refused"):
            print(f"  {case.map}, {case.row}, {case.value}: {end.reason}")
    if plot is not None:
        _draw(todo, found, plot)
        names = ["map", "model", "value", "outcome", "read", "steps", "iterations", "cuts", "seconds", "reason"]
        rows = (
            [case.map, case.row, case.value, end.status, end.text, end.steps, end.iterations, end.cuts, f"{end.seconds:.2f}",
             end.reason]
            for case, end in zip(todo, found, strict=True)
        )  # fmt: skip
        write_table(plot.with_suffix(".csv"), names, rows)
    return table


def _draw(todo: Sequence[Case], found: Sequence[Outcome], path: Path) -> None:
    titles = list(dict.fromkeys(case.map for case in todo))
    figure = new_figure(16.0, 1.65 * -(-len(titles) // 2))
    for axes, title in zip(figure.subplots(-(-len(titles) // 2), 2).ravel(), titles, strict=False):
        here = [(case, end) for case, end in zip(todo, found, strict=True) if case.map == title]
        names = list(dict.fromkeys(case.row for case, _ in here))
        values = list(dict.fromkeys(case.value for case, _ in here))
        for case, end in here:
            x, y = values.index(case.value), names.index(case.row)
            axes.add_patch(Rectangle((x - 0.48, y - 0.46), 0.96, 0.92, color=COLOURS[end.status], linewidth=0))
            axes.text(x, y, end.text, ha="center", va="center", fontsize=8)
        axes.set(xlim=(-0.5, len(values) - 0.5), ylim=(len(names) - 0.5, -0.5), title=title)
        axes.set_xticks(range(len(values)), values, fontsize=8)
        axes.set_yticks(range(len(names)), names, fontsize=8)
        axes.title.set_fontsize(10)
        axes.tick_params(length=0)
    for axes in figure.axes[len(titles) :]:
        axes.axis("off")
        patches = [Patch(color=COLOURS[status], label=MEANING[status]) for status in COLOURS]
        axes.legend(handles=patches, loc="center", frameon=False, fontsize=9)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "extremes.png")
