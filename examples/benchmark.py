"""What the parts of an analysis cost, as ratios in one run: `python -m examples.benchmark [--large]`, or with
one of --million, --meshing, --command.

Every scene is the notched beam with other element sizes, and each is measured in a process of its own, so that its peak
memory is its own. "elastic solve" is one factorization and solve of the whole by SuperLU with its minimum degree ordering,
"sparse factorization" the factorization in it, which an iteration that condenses nothing needs.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path
from unittest import mock

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from cohesive import Concrete, CrackPlane, Scene, run
from cohesive.algebra.bordered import SparseStiffness
from cohesive.algebra.threads import begin_with_one
from cohesive.model.build import build
from cohesive.solver.stepper import solve
from meshing import PlaneSpecimen
from meshing.generation import refinement
from meshing.generation.polygon import mesh_face

#: crack_size, far_size, shape, order, model
Size = tuple[float, float, str, int, str]


def _t3(crack_size: float, far_size: float) -> Size:
    return (crack_size, far_size, "triangle", 1, "discrete")


#: about 2e3, 2e4 and 1e5 unknowns
SIZES: dict[str, Size] = {
    "T3 2e3": _t3(0.5, 6.0),
    "T3 2e4": _t3(0.5, 1.05),
    "T3 1e5": _t3(0.25, 0.45),
    "band 2e3": (0.5, 6.0, "triangle", 1, "smeared"),
    "band 2e4": (0.5, 1.05, "triangle", 1, "smeared"),
}
LARGE: dict[str, Size] = {
    "Q4 1e5": (0.25, 0.42, "quad", 1, "discrete"),
    "T6 1e5": (0.5, 0.93, "triangle", 2, "discrete"),
    "Q8 1e5": (0.5, 0.75, "quad", 2, "discrete"),
    "band 1e5": (0.25, 0.45, "triangle", 1, "smeared"),
}
MILLION = _t3(0.1, 0.14)
#: the same crack in a larger bulk, and a larger crack in about the same bulk
BULK = {"far 6": _t3(0.5, 6.0), "far 1.05": _t3(0.5, 1.05), "far 0.5": _t3(0.5, 0.5)}
CRACK = {
    "crack 1": _t3(1.0, 1.01),
    "crack 0.5": _t3(0.5, 1.05),
    "crack 0.25": _t3(0.25, 1.08),
    "crack 0.125": _t3(0.125, 1.15),
}
#: both ways of solving, with fewer steps
BOTH = {"T3 2e4": SIZES["T3 2e4"], "band 2e3": SIZES["band 2e3"]}
BOTH_STEPS = 12
#: of a sweep
MATERIALS = 20

Row = dict[str, float]


def best_of(n: int, call: Callable[[], object]) -> float:
    """Shortest of n timings, seconds."""
    times = []
    for _ in range(n):
        clock = time.perf_counter()
        call()
        times.append(time.perf_counter() - clock)
    return min(times)


def changes(size: Size) -> dict[str, object]:
    """What makes the scene of a size out of the built-in one."""
    keys = ("mesh.crack_size", "mesh.far_size", "mesh.shape", "mesh.order", "model.kind")
    return dict(zip(keys, size, strict=True))


@cache
def analysis(size: Size, condensation: str = "always", steps: int = 60) -> Row:
    """Seconds for the parts of one softening analysis, the sizes of its systems, and peak memory in MB; in a process of its
    own."""
    return apart(_analysis, size, condensation, steps)


def _analysis(size: Size, condensation: str, steps: int) -> Row:
    import gmsh  # noqa: F401  # loading it is no cost of the analysis

    scene = Scene.load("notched-beam").with_(**changes(size), **{"solver.condensation": condensation, "stage.0.steps": steps})
    loaded = memory()
    model = build(scene)
    found: list[int] = []

    def newton() -> None:
        found[:] = [step.equilibrium.iterations for step in solve(model.problem, scene.stages, model.recorded)]

    repeats = 7 if scene.model.kind == "discrete" else 2  # what else the machine does only adds
    seconds = best_of(1 if condensation == "never" else repeats, newton)
    parts, peak = dict(model.timings), memory()
    if model.total_dofs < 500_000:
        again = build(scene).timings  # the better of two, as for the elastic solve
        parts = {name: min(parts[name], again[name]) for name in parts}
        if condensation == "always":  # with its result, without pictures
            parts["run"] = best_of(2, lambda: run(scene))
    return parts | {
        "newton": seconds,
        "iterations": sum(found),
        "iteration": seconds / sum(found),
        "unknowns": model.total_dofs,
        "active": model.active_dofs,
        "loaded": loaded,
        "peak": peak,
    }


def growth(sizes: Mapping[str, Size]) -> dict[str, Row]:
    """Unknowns, iterations and seconds per iteration of condensed runs that take turns, so that their ratios are steady."""
    scenes = {name: Scene.load("notched-beam").with_(**changes(size)) for name, size in sizes.items()}
    models = {name: build(scene.with_(**{"solver.condensation": "always"})) for name, scene in scenes.items()}
    rows: dict[str, Row] = {}
    for _ in range(7):
        for name, model in models.items():
            clock = time.perf_counter()
            steps = solve(model.problem, scenes[name].stages, model.recorded)
            iterations = sum(step.equilibrium.iterations for step in steps)
            iteration = (time.perf_counter() - clock) / iterations
            best = min(iteration, rows[name]["iteration"]) if name in rows else iteration
            rows[name] = {
                "unknowns": model.total_dofs,
                "active": model.active_dofs,
                "iterations": iterations,
                "iteration": best,
            }
    return rows


@cache
def sparse(size: Size) -> Row:
    """Seconds for one sparse factorization and one elastic solve, and the factor's size in MB; in a process of its own."""
    return apart(_sparse, size)


def _sparse(size: Size) -> Row:
    scene = Scene.load("notched-beam").with_(**changes(size), **{"solver.condensation": "never"})
    return elastic_solve(scene, "MMD_AT_PLUS_A")


def elastic_solve(scene: Scene, order: str, repeats: int = 2) -> Row:
    """One sparse factorization and one elastic solve of a scene without condensation, by SuperLU in an order of its own or
    ("NATURAL") in that of the dissection."""
    problem = build(scene).problem
    assert isinstance(problem.stiffness, SparseStiffness)
    rows, columns, values = problem.operator.stiffness(problem.point_law.elastic())
    matrix = problem.stiffness.factor * problem.stiffness.matrix
    K = (matrix + sp.coo_array((values, (rows, columns)), shape=matrix.shape)).tocsc()
    if order == "NATURAL":
        K = K[problem.stiffness.order][:, problem.stiffness.order].tocsc()
    del problem, matrix  # and the factor with which it was seen to be held
    load = np.random.default_rng(0).normal(size=K.shape[0])
    factors: list[spla.SuperLU] = []

    def factorize() -> None:
        factors[:] = [spla.splu(K, permc_spec=order, diag_pivot_thresh=0.0, options={"SymmetricMode": True})]

    factorization = best_of(repeats, factorize)
    entry = 12  # bytes: a number and its row
    solve = best_of(2, lambda: factors[0].solve(load))
    return {"factorization": factorization, "elastic": factorization + solve, "factor": entry * factors[0].nnz / 2**20}


def law(points: int = 200_000) -> Row:
    """Cost of `update` and of the traction alone, microseconds a point."""
    plane = CrackPlane(Concrete.preset("reinhardt"), 0.3)
    random = np.random.default_rng(1)
    jump = random.uniform(-1.0, 1.0, (points, 2)) * plane.concrete.Zm
    Z = random.uniform(0.0, 1.0, points) * plane.concrete.Zm
    update, traction = best_of(5, lambda: plane.update(jump, Z)), best_of(5, lambda: plane.traction(jump, Z))
    return {"update": 1e6 * update / points, "traction": 1e6 * traction / points, "ratio": update / traction}


def command(size: Size | None, repeats: int = 3) -> Row:
    """Seconds of `cohesive run notched-beam` from its start to its exit, and where they go.

    Imports are those of a process that does nothing else, frames the difference to a run that writes none.
    """

    def run(folder: str, *more: str) -> tuple[float, Row]:
        sets = [word for key, value in changes(size).items() for word in ("--set", f"{key}={value}")] if size else []
        seconds = _process("-m", "cohesive", "run", "notched-beam", "-o", folder, *sets, *more)
        return seconds, json.loads((Path(folder) / "run.json").read_text(encoding="utf-8"))["timings"]

    ours = "cohesive.commands.run"
    imports = ("gc", f"{ours}, gmsh", f"{ours}, gmsh, cohesive.figures.drawing")  # without the exit, which is that of the run
    codes = [f"import gc, os; gc.set_threshold(50_000); import {names}; os._exit(0)" for names in imports]
    with tempfile.TemporaryDirectory() as folder:
        loads: list[list[float]] = []
        runs, bare = [], []
        for _ in range(repeats):
            loads.append([_process("-c", code) for code in codes])
            runs.append(run(folder))
            bare.append(run(folder, "--set", "output.frames=0"))
    python, libraries, drawing = (min(column) for column in zip(*loads, strict=True))
    whole, timings = min(runs, key=lambda entry: entry[0])
    pictures = min(timings["output"] for _, timings in bare)
    row = {
        "interpreter": python,
        "numpy, scipy, gmsh, ...": libraries - python,
        "matplotlib": drawing - libraries,
        "mesh": timings["mesh"],
        "assemble, condense": timings["assemble"] + timings["condense"],
        "Newton, history": timings["newton"],
        "pictures": pictures,
        "frames": timings["output"] - pictures,
    }
    return row | {"scene, summary, exit": whole - sum(row.values()), "whole command": whole}


def apart(function: Callable[..., Row], *arguments: object) -> Row:
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def memory() -> float:
    """Peak memory of this process, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


def table(title: str, columns: Sequence[str], rows: Mapping[str, Sequence[float]]) -> dict[str, Row]:
    """Print a table and return it."""
    widths = [max(10, len(column) + 2) for column in columns]
    print(f"\n{title}\n{'':26s}" + "".join(f"{c:>{w}s}" for c, w in zip(columns, widths, strict=True)))
    for name, values in rows.items():
        cells = (f"{v:>{w},.0f}" if v >= 100 else f"{v:>{w}.3g}" for v, w in zip(values, widths, strict=True))
        print(f"{name:26s}" + "".join(cells), flush=True)
    return {name: dict(zip(columns, values, strict=True)) for name, values in rows.items()}


def main(large: bool = False, sizes: Mapping[str, Size] = SIZES) -> dict[str, dict[str, Row]]:
    """Measure, print the tables and return them."""
    sizes = {**sizes, **(LARGE if large else {})}
    done = {name: analysis(size) | sparse(size) for name, size in sizes.items()}
    found = {}
    found["analysis"] = table(
        "Condense + Newton, and the whole run from the scene to its result, over one elastic solve (60 steps; seconds)",
        ("unknowns", "active", "mesh", "assemble", "condense", "Newton", "elastic solve", "ratio", "run", "run, ratio"),
        {
            name: [*(r[key] for key in ("unknowns", "active", "mesh", "assemble", "condense", "newton", "elastic")),
                   (r["condense"] + r["newton"]) / r["elastic"], r["run"], r["run"] / r["elastic"]]
            for name, r in done.items()
        },
    )  # fmt: skip
    found["iteration"] = table(
        "One sparse factorization over one condensed iteration (ms)",
        ("unknowns", "active", "factorization", "iteration", "ratio"),
        {
            name: [r["unknowns"], r["active"], 1e3 * r["factorization"], 1e3 * r["iteration"],
                   r["factorization"] / r["iteration"]]
            for name, r in done.items()
        },
    )  # fmt: skip
    found["memory"] = table(
        "Peak memory of the analysis over the size of the sparse factor (MB; the libraries alone take the first column)",
        ("loaded", "peak", "factor", "peak/factor", "(peak - loaded)/factor"),
        {
            name: [r["loaded"], r["peak"], r["factor"], r["peak"] / r["factor"], (r["peak"] - r["loaded"]) / r["factor"]]
            for name, r in done.items()
        },
    )
    return found


def comparisons(
    both: Mapping[str, Size] = BOTH, bulk: Mapping[str, Size] = BULK, crack: Mapping[str, Size] = CRACK
) -> dict[str, dict[str, Row]]:
    """Both ways of Newton, growth with bulk and crack, and the law: print the tables and return them."""
    rows = {}
    for name, size in both.items():
        whole, condensed = (analysis(size, condensation, BOTH_STEPS) for condensation in ("never", "always"))
        once = condensed["condense"] + condensed["newton"]
        pair = (whole["iteration"], condensed["iteration"])
        rows[name] = [
            whole["unknowns"],
            whole["newton"],
            once,
            whole["newton"] / once,
            *(1e3 * s for s in pair),
            pair[0] / pair[1],
        ]
    columns = ("unknowns", "sparse (s)", "condensed (s)", "ratio", "iteration, sparse (ms)", "condensed (ms)", "per iteration")
    title = f"Sparse Newton over condense + condensed Newton, and per iteration ({BOTH_STEPS} steps)"
    found = {"newton": table(title, columns, rows)}
    for key, title, sizes in (
        ("bulk", "Growth with the bulk: the same crack, elements far from it smaller; to the first row", bulk),
        ("crack", "Growth with the crack: its elements smaller in about the same bulk; to the first row", crack),
    ):
        done = growth(sizes)
        first = next(iter(done.values()))
        found[key] = table(
            title,
            ("unknowns", "active", "iterations", "iteration (ms)", "unknowns, ratio", "active, ratio", "iteration, ratio"),
            {
                name: [r["unknowns"], r["active"], r["iterations"], 1e3 * r["iteration"],
                       *(r[key] / first[key] for key in ("unknowns", "active", "iteration"))]
                for name, r in done.items()
            },
        )  # fmt: skip
    cost = law()
    title = "The law at a point: traction, tangent and history over the traction alone (microseconds a point)"
    found["law"] = table(title, ("update", "traction", "ratio"), {"CrackPlane": list(cost.values())})
    return found


def million() -> dict[str, dict[str, Row]]:
    """One run with a million unknowns: print its times and memory, and return them."""
    r = analysis(MILLION)
    columns = ("unknowns", "active", "mesh", "assemble", "condense", "newton", "peak")
    title = "A million unknowns: seconds, and peak memory in MB"
    return {"million": table(title, columns, {"T3 1e6": [r[column] for column in columns]})}


def meshing(sizes: Mapping[str, Size] = SIZES) -> dict[str, dict[str, Row]]:
    """Plane meshes by gmsh alone over those whose cells are divided: print nodes and seconds of the processor, return them."""
    rows = {}
    for name, size in sizes.items():
        scene = Scene.load("notched-beam").with_(**changes(size))
        assert isinstance(scene.specimen, PlaneSpecimen)
        assert scene.sizes is not None
        outline = scene.specimen.outline()
        row: list[float] = []
        if not refinement.halvings(outline, scene.sizes):
            continue
        for up_to in (10**9, refinement.WHOLE_UP_TO):
            with mock.patch.object(refinement, "WHOLE_UP_TO", up_to):
                clock = time.process_time()
                nodes = len(mesh_face(outline, scene.sizes, conforming=True).points)
                row += [nodes, time.process_time() - clock]
        rows[name] = [*row, row[3] / row[1]]
    columns = ("nodes", "seconds", "divided: nodes", "seconds", "ratio")
    return {"meshing": table("Meshes by gmsh, and from coarser ones by division", columns, rows)}


def split() -> dict[str, dict[str, Row]]:
    """Where the seconds of the command go: print them for two sizes of the beam, and return them."""
    columns = {"as it is": command(None), "1e5 unknowns": command(SIZES["T3 1e5"], 2)}
    rows = {part: [row[part] for row in columns.values()] for part in columns["as it is"]}
    found = {"command": table("From `cohesive run notched-beam` to its exit, seconds", tuple(columns), rows)}
    with tempfile.TemporaryDirectory() as folder:
        arguments = ("sweep", "notched-beam", "--vary", f"material.Gf=0.05:0.1:{MATERIALS}", "--workers", "1", "-o", folder)
        swept = best_of(3, lambda: _process("-m", "cohesive", *arguments))
    one = columns["as it is"]["whole command"]
    title = f"`cohesive sweep` over {MATERIALS} materials in one process, over one run (seconds)"
    return found | {"sweep": table(title, ("sweep", "run", "ratio"), {"as it is": [swept, one, swept / one]})}


def _process(*arguments: str) -> float:
    """Seconds of a process of this interpreter."""
    return best_of(1, lambda: subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--large", action="store_true", help="also 1e5 unknowns with other elements and with the band")
    parser.add_argument("--million", action="store_true", help="only one run with 1e6 unknowns: a minute, 3 GB")
    parser.add_argument("--meshing", action="store_true", help="only meshes with and without division, to 1e6 unknowns")
    parser.add_argument("--command", action="store_true", help="only where the seconds of a command go, and a sweep")
    options = parser.parse_args()
    begin_with_one()  # as the command does
    if options.million:
        million()
    elif options.meshing:
        meshing({"T3 1e5": SIZES["T3 1e5"], "Q4 1e5": LARGE["Q4 1e5"], "T6 1e5": LARGE["T6 1e5"], "T3 1e6": MILLION})
    elif options.command:
        split()
    else:
        main(options.large)
        comparisons()
