"""Random valid scenes, plausible ones and extreme ones, and what becomes of them.

    python -m tests.random_scenes [--count 1000] [--extreme] [--first SEED] [--condensed | --twins]

prints a table of the outcomes, the errors of the energy balance, and the slowest runs. With `--condensed` each is run with
and without condensation at the tightest tolerance, and the largest difference of the histories is printed. With `--twins`
each small one is run in other units, of another thickness and in a mirror, and the differences are printed.
"""

from __future__ import annotations

import argparse
import collections
import re
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from tqdm import tqdm

from cohesive import NotConverged, Result, Scene, SceneError, run
from cohesive.scenes.scene import built_in
from meshing import MeshError
from tests.twins import Twin, mirrored, scaled, thicker

#: what sets energy free that the balance shows, and is said in a note
NAMED = re.compile("snaps at|goes back from|lets go of|the crack has run through")

#: named softening curves
CURVES = ("exponential", "linear", "hordijk", "petersson", "wittmann", "fib-2010")

#: energies, whose balance is checked
PARTS = ("elastic", "stored", "dissipated", "contact_work", "released")


@dataclass(frozen=True)
class Outcome:
    """What became of a scene: "ended", "stopped" or "refused", the reason, the error of the balance, whether a snap or the
    like is named, and CPU seconds."""

    status: str
    reason: str = ""
    balance: float = 0.0
    is_named: bool = False
    seconds: float = 0.0


def random_scene(seed: int, extreme: bool = False, small: bool = False) -> Scene:
    """A valid scene that takes some tenths of a second; if `small` less, with as few elements and steps as will do."""
    rng = np.random.default_rng([seed, extreme])
    names = [name for name in built_in() if extreme or rng.random() < 0.3 or not name.endswith("3d")]
    base = Scene.load(str(rng.choice(names)))
    data = {key: value for key, value in base.data.items() if key != "reference"}
    solid, smeared = base.dimension == 3, bool(rng.random() < 0.4)
    if base.kind == "single-crack-3d":
        smeared = False
    data["material"] = _material(rng, extreme)
    data["model"] = {
        **data.get("model", {}), "kind": "smeared" if smeared else "discrete", "plane": str(rng.choice(["stress", "strain"])),
    }  # fmt: skip
    data["model"].pop("half", None)
    if base.specimen.dimensions == (3,):  # no plane body
        del data["model"]["plane"]
    shape = "triangle" if base.kind == "single-crack-3d" else str(rng.choice(["triangle", "quad"]))
    order = 1 if solid else int(rng.choice([1, 2, 2]))
    length = base.crack_area**0.5 if solid else base.crack_area / (base.specimen.thickness or 1.0)
    size = length / rng.uniform(4.0, 6.0 if solid or small else 12.0)
    data["mesh"] = {"crack_size": size, "far_size": size * rng.uniform(2.0, 5.0), "shape": shape, "order": order}
    if smeared:
        data["band"] = {"width": min(size, 3.0)}  # narrower than any notch
    if smeared and base.kind not in ("single-crack-3d",) and rng.random() < 0.2 and not solid and not small:
        data["band"] = {"where": "everywhere"}
    if not smeared:
        data["interface"] = {"quadrature": str(rng.choice(["nodal", "gauss"]))}
        if base.specimen.symmetry() is not None and not solid and rng.random() < 0.3:
            data["model"]["half"] = True
    data["solver"], data["output"] = {"step_growth": float(rng.choice([1.0, 1.0, 3.0]))}, {"frames": 0}
    data["stage"] = _stages(rng, data["stage"])
    if len(data["stage"]) == 1 and rng.random() < 0.15:
        energy = data["material"]["Gf"] * base.crack_area
        data["stage"] = [{"control": "dissipation", "to": float(energy * rng.uniform(0.2, 0.8)), "steps": 25}]
    if small:
        data["stage"] = [{**stage, "steps": 8} for stage in data["stage"]]
    return Scene(data, base.folder)


def _material(rng: np.random.Generator, extreme: bool) -> dict[str, Any]:
    def between(low: float, high: float) -> float:
        """Log-uniform."""
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    wide = 30.0 if extreme else 1.0
    softening = str(rng.choice([*CURVES, "kink"]))
    return {
        "E": between(20e3 / wide, 45e3 * wide),
        "nu": float(rng.uniform(0.0, 0.49) if extreme else rng.uniform(0.1, 0.25)),
        "ft": between(1.5 / wide, 5.0 * wide),
        "Gf": between(0.04 / wide, 0.2 * wide),
        "unusual": extreme,
        "contact": str(rng.choice(["printed", "potential"])),
        "softening": {"kink": [between(0.3, 1.2), float(rng.uniform(0.15, 0.4))]} if softening == "kink" else softening,
    }


def _stages(rng: np.random.Generator, stages: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The stages of a built-in scene, some steps each, some with a reversal."""
    found = []
    for stage in stages:
        targets = np.atleast_1d(np.asarray(stage["to"], dtype=float)) * rng.uniform(0.3, 1.2)
        targets = targets[:2].tolist()
        if rng.random() < 0.4:
            low = targets[-1] * rng.uniform(-0.05, 0.7)
            targets += [low, targets[-1] * rng.uniform(0.8, 1.3)]
        kept = {key: value for key, value in stage.items() if key not in ("step", "steps", "unload", "until")}
        found.append({**kept, "to": targets, "steps": int(rng.integers(20, 35))})
    return found


def with_steps(scene: Scene, times: int) -> Scene:
    """The scene with so many times as many steps."""
    return scene.with_(stage=[{**stage, "steps": times * stage["steps"]} for stage in scene.data["stage"]])


def outcome(scene: Scene) -> Outcome:
    """Run a scene; what a result must keep is asserted, and every exception but the named ones is passed on."""
    clock = time.process_time()
    status, reason = "ended", ""
    try:
        result = run(scene)
    except (SceneError, MeshError) as error:
        return Outcome("refused", str(error), seconds=time.process_time() - clock)
    except NotConverged as error:
        assert isinstance(error.result, Result)
        result, status, reason = error.result, "stopped", str(error)
    seconds = time.process_time() - clock
    if not result.steps:
        return Outcome(status, reason, seconds=seconds)
    assert_sound(result)
    named = any(NAMED.search(note) for note in result.notes)
    return Outcome(status, reason, result.energy_error, named, seconds)


def assert_sound(result: Result) -> None:
    """Finite numbers, dissipation that never falls, columns of equal length."""
    h = result.history
    assert len({len(column) for column in h.values()}) == 1
    for name, column in h.items():
        if name != "effective_length":  # which not every body has
            assert np.isfinite(column).all(), name
    scale = max(abs(h["work"]).max(), h["dissipated"].max())
    assert np.diff(h["dissipated"]).min() >= -1e-12 * scale


def difference(seed: int) -> float | None:
    """Largest difference of a history with and without condensation, in parts of each column's scale; None if it stops."""
    scene = random_scene(seed).with_(**{"solver.tol": 1e-11, "solver.step_growth": 1.0})
    try:
        one, other = (run(scene.with_(**{"solver.condensation": way})).history for way in ("always", "never"))
    except (NotConverged, SceneError, MeshError):
        return None
    names = ("load", "opening", "driven", "work", "elastic", "dissipated")
    if len(one["load"]) != len(other["load"]):
        return np.inf
    return max(float(abs(one[name] - other[name]).max() / max(abs(one[name]).max(), 1e-300)) for name in names)


def twins(scene: Scene) -> dict[str, Twin]:
    """The twins of a scene by name. Powers of two keep every bit of the numbers."""
    found = {"scaled": scaled(scene, 2.0, 2.0)}
    if scene.dimension == 2:
        found |= {"thicker": thicker(scene, 2.0), "mirrored": mirrored(scene)}
    return found


def twin_differences(seed: int) -> dict[str, float] | None:
    """Differences of the histories of a small scene's twins from what follows from its own; None if it stops."""
    scene = random_scene(seed, small=True)
    try:
        own = run(scene).history
        return {name: twin.difference(own, run(twin.scene).history) for name, twin in twins(scene).items()}
    except NotConverged:
        return None


def table(count: int, extreme: bool = False, first: int = 0) -> list[Outcome]:
    """Run so many scenes and print what became of them."""
    found = []
    for seed in tqdm(range(first, first + count), disable=None):
        try:
            found.append(outcome(random_scene(seed, extreme)))
        except Exception as error:
            error.add_note(f"random_scene({seed}, {extreme})")
            raise
        if found[-1].status == "stopped":
            print(f"seed {seed}: {found[-1].reason[:300]}", flush=True)
        if found[-1].balance > 0.01 and not found[-1].is_named:
            finer = outcome(with_steps(random_scene(seed, extreme), 4))
            print(f"seed {seed}: balance {found[-1].balance:.2g}, with a quarter of the steps {finer.balance:.2g}", flush=True)
    print(dict(collections.Counter(each.status for each in found)))
    started = [each for each in found if each.status != "refused"]
    errors = np.sort([each.balance for each in started if not each.is_named])
    named = np.sort([each.balance for each in started if each.is_named])
    for what, values in (("no snap", errors), ("a snap is named", named)):
        if len(values):
            quantiles = ", ".join(f"{100 * q:g} % {np.quantile(values, q):.1e}" for q in (0.5, 0.9, 0.99, 1.0))
            print(f"error of the balance, {what} ({len(values)}): {quantiles}")
    slowest = np.argsort([-each.seconds for each in found])[:10]
    print("slowest:", ", ".join(f"seed {first + i} {found[i].seconds:.1f} s" for i in slowest))
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--extreme", action="store_true")
    parser.add_argument("--condensed", action="store_true")
    parser.add_argument("--twins", action="store_true")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.count)
    if options.twins:
        for seed in seeds:
            print(seed, twin_differences(seed), flush=True)
    elif options.condensed:
        differences = {seed: value for seed in seeds if (value := difference(seed)) is not None}
        worst = sorted(differences, key=lambda seed: -differences[seed])[:5]
        print(f"{len(differences)} compared, largest: " + ", ".join(f"seed {s} {differences[s]:.1e}" for s in worst))
    else:
        table(options.count, options.extreme, options.first)
