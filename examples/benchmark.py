"""Cost of the parts of an analysis, as ratios in one run: `python -m examples.benchmark [--large]`.

For each size: seconds for mesh, assembly, condensation and Newton, per Newton iteration, for one sparse
factorization of the whole in an iteration of the uncondensed method, and for one elastic factor-and-solve
with SuperLU's minimum degree ordering. Then the law: microseconds a point, and the tangent against the
traction alone.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from cohesive import Concrete, CrackPlane, Scene, run
from cohesive.linear import SparseStiffness
from cohesive.simulation import build

#: name: (crack_size, far_size, shape, order) of the notched beam, about 2e3, 2e4 and 1e5 unknowns
SIZES = {
    "T3 2e3": (0.5, 6.0, "triangle", 1),
    "T3 2e4": (0.5, 1.05, "triangle", 1),
    "T3 1e5": (0.25, 0.45, "triangle", 1),
}
LARGE = {
    "Q4 1e5": (0.25, 0.42, "quad", 1),
    "T6 1e5": (0.5, 0.93, "triangle", 2),
    "Q8 1e5": (0.5, 0.75, "quad", 2),
}


def best_of(n: int, call: Callable[[], object]) -> float:
    """Shortest of n timings, seconds."""
    times = []
    for _ in range(n):
        clock = time.perf_counter()
        call()
        times.append(time.perf_counter() - clock)
    return min(times)


def analysis(crack_size: float, far_size: float, shape: str, order: int) -> dict[str, float]:
    """Times of one softening analysis of the notched beam, and of the elastic solve and the factorization beside it."""
    scene = Scene.load("notched-beam").with_(
        **{"mesh.crack_size": crack_size, "mesh.far_size": far_size, "mesh.shape": shape, "mesh.order": order}
    )
    full = build(scene.with_(**{"solver.reduction": "none"}))
    problem = full.problem
    assert isinstance(problem.stiffness, SparseStiffness)
    rows, columns, values = problem.points.stiffness(problem.law.elastic())
    K = (problem.stiffness.matrix + sp.coo_array((values, (rows, columns)), shape=problem.stiffness.matrix.shape)).tocsc()
    load = np.zeros(K.shape[0])
    load[problem.drives] = 1.0

    def elastic() -> object:
        return spla.splu(K, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve(load)

    factor = best_of(2, elastic)
    results = [run(scene.with_(**{"solver.reduction": "condensed"})) for _ in range(2)]
    best = min(results, key=lambda result: result.timings["condense"] + result.timings["newton"])
    t = best.timings
    return {
        "unknowns": best.total_dofs,
        "active": best.active_dofs,
        "mesh": t["mesh"],
        "assemble": t["assemble"],
        "condense": t["condense"],
        "newton": t["newton"],
        "iteration": t["newton"] / best.iterations,
        "elastic": factor,
        "analysis/elastic": (t["condense"] + t["newton"]) / factor,
        "factor/iteration": factor / (t["newton"] / best.iterations),
    }


def law(points: int = 200_000) -> dict[str, float]:
    """Cost of `update` and of the traction alone, microseconds a point."""
    plane = CrackPlane(Concrete.preset("reinhardt"), 0.3)
    random = np.random.default_rng(1)
    jump = random.uniform(-1.0, 1.0, (points, 2)) * plane.concrete.Zm
    Z = random.uniform(0.0, 1.0, points) * plane.concrete.Zm
    update, traction = best_of(5, lambda: plane.update(jump, Z)), best_of(5, lambda: plane.traction(jump, Z))
    return {"update": 1e6 * update / points, "traction": 1e6 * traction / points, "ratio": update / traction}


def main(large: bool = False) -> dict[str, dict[str, float]]:
    """Print the tables and return them."""
    table = {}
    for name, sizes in (SIZES | LARGE if large else SIZES).items():
        table[name] = analysis(*sizes)
        if len(table) == 1:
            print(f"{'':8s}" + "".join(f"{column:>17s}" for column in table[name]))
        print(f"{name:8s}" + "".join(f"{value:17.4g}" for value in table[name].values()), flush=True)
    table["law"] = law()
    print("law, microseconds a point: " + ", ".join(f"{name} {value:.3g}" for name, value in table["law"].items()))
    return table


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--large", action="store_true", help="also quadrilaterals and second order")
    main(parser.parse_args().large)
