"""What a crack surface costs in three dimensions, as ratios in one run: `python -m examples.benchmark_solid [--elastic]`.

The notched beam with about 1e5 unknowns and four crack surfaces, the largest of 1521 node pairs. Each is measured in a
process of its own, three minutes in all, with the threads that the command takes: the parts of a whole softening analysis
(40 steps), how many of its iterations needed a factorization of their own, and peak memory. With --elastic the same bodies
are solved once, elastic, by one sparse factorization: by SuperLU in the order of the dissection, which in space is faster
than its minimum degree (a quarter of an hour in all), and the analyses are compared with that.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping

from cohesive import Scene
from cohesive.algebra.bordered import DenseStiffness
from cohesive.algebra.threads import begin_with_one
from cohesive.model.build import build
from cohesive.solver.stepper import solve
from examples.benchmark import Row, apart, elastic_solve, memory, table

#: crack_size, far_size, layers
Size = tuple[float, float, int]

SIZES: dict[str, Size] = {
    "231 pairs": (2.5, 2.6, 20),
    "435 pairs": (1.8, 3.4, 28),
    "861 pairs": (1.25, 5.0, 40),
    "1521 pairs": (0.65, 10.0, 38),
}


def scene_of(size: Size, **further: object) -> Scene:
    """The beam with these element sizes."""
    sizes = dict(zip(("mesh.crack_size", "mesh.far_size", "mesh.layers"), size, strict=True))
    return Scene.load("notched-beam-3d").with_(**sizes, **further)


def analysis(size: Size) -> Row:
    """Seconds for the parts of one softening analysis, the sizes of its systems, and peak memory in MB; in a process of its
    own."""
    return apart(_analysis, size)


def _analysis(size: Size) -> Row:
    scene = scene_of(size)
    loaded = memory()
    model = build(scene)
    clock = time.perf_counter()
    iterations = sum(step.equilibrium.iterations for step in solve(model.problem, scene.stages, model.recorded))
    newton = time.perf_counter() - clock
    assert isinstance(model.problem.stiffness, DenseStiffness)
    return dict(model.timings) | {
        "newton": newton,
        "iterations": iterations,
        "iteration": newton / iterations,
        "factorizations": model.problem.stiffness.factorizations,
        "unknowns": model.total_dofs,
        "active": model.active_dofs,
        "memory": memory() - loaded,
    }


def main(with_elastic: bool = False, sizes: Mapping[str, Size] = SIZES) -> dict[str, dict[str, Row]]:
    """Measure, print the tables and return them."""
    done = {}
    for name, size in sizes.items():
        done[name] = analysis(size)
        print(f"{name}: {', '.join(f'{part} {value:.3g}' for part, value in done[name].items())}", flush=True)
    columns = ("unknowns", "active", "mesh", "assemble", "condense", "newton", "iterations", "factorizations", "memory")
    found = {
        "analysis": table(
            "Beam in space, 40 steps: seconds, iterations and those that factored, memory beyond the libraries (MB)",
            columns,
            {name: [row[column] for column in columns] for name, row in done.items()},
        )
    }
    first = next(iter(done.values()))
    found["growth"] = table(
        "Growth with the crack, to the first row",
        ("active", "condense", "iteration (ms)", "active, ratio", "iteration, ratio"),
        {
            name: [row["active"], row["condense"], 1e3 * row["iteration"], row["active"] / first["active"],
                   row["iteration"] / first["iteration"]]
            for name, row in done.items()
        },
    )  # fmt: skip
    if with_elastic:
        solved = {
            name: apart(elastic_solve, scene_of(size, **{"solver.condensation": "never"}), "NATURAL", 1)
            for name, size in sizes.items()
        }
        found["elastic"] = table(
            "Over one elastic factorization and solve (s, MB)",
            ("elastic solve", "condense + Newton", "ratio", "factor", "memory over factor"),
            {
                name: [solved[name]["elastic"], row["condense"] + row["newton"],
                       (row["condense"] + row["newton"]) / solved[name]["elastic"], solved[name]["factor"],
                       row["memory"] / solved[name]["factor"]]
                for name, row in done.items()
            },
        )  # fmt: skip
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--elastic", action="store_true", help="also the elastic solve to compare with: 15 minutes, 12 GB")
    begin_with_one()  # as the command does
    main(parser.parse_args().elastic)
