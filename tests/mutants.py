"""Mutation trial: do the tests notice a slip of the pen in the code?

    python -m tests.mutants --count 300 --seed 1

changes one place of law, cracks, algebra, solver or meshing at a time, in a copy of the package, and runs the tests that
execute the changed line, the cheapest first, until one fails. `--record` finds out which tests those are (the normal suite
once, with coverage); the first trial does so by itself. `mutants.toml` names mutants that change nothing that can be
observed, each with the reason. Not for Windows: each mutant is tried in a fork of a process that has loaded the libraries.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import queue
import random
import resource
import shutil
import signal
import sys
import tomllib
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.mutation import Mutant, mutants

ROOT = Path(__file__).parents[1]
ROOMS = ("cohesive/law", "cohesive/cracks", "cohesive/algebra", "cohesive/solver", "meshing")
LEFT_OUT = ("cohesive/algebra/petsc/",)  # needs optional packages
COPIED = (
    "cohesive", "meshing", "tests", "examples", "pyproject.toml", "README.md", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE",
)  # fmt: skip

#: of a trial: CPU time over the recorded time of its tests and besides, s, and memory, bytes
SLOWER, BESIDES, MEMORY = 4.0, 30.0, 6 * 2**30

#: new processes are forks of one that has loaded the libraries
FORKS = multiprocessing.get_context("forkserver")
LIBRARIES = ("pytest", "scipy.sparse.linalg", "scipy.special", "scipy.optimize", "matplotlib.figure", "gmsh", "meshio")
FORKS.set_forkserver_preload(list(LIBRARIES))

OUTCOMES = ("killed", "timed out", "survived", "not covered", "equivalent")


class Durations:
    """A plugin of pytest: seconds of each test that passed, by its name."""

    def __init__(self) -> None:
        self.seconds: Counter[str] = Counter()
        self.failed: set[str] = set()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] += report.duration
        if report.failed:
            self.failed.add(report.nodeid)


def copied(folder: Path) -> Path:
    """A copy of what the tests need."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in filter(lambda name: (ROOT / name).exists(), COPIED):
        copy: Callable[..., object] = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, folder / name)
    return folder


def record(folder: Path, asked: list[str]) -> None:
    """Run tests once, with coverage: which lines each executes, and how long it takes; added to what is recorded."""
    at, tests = copied(folder / "recorded"), Durations()
    os.environ |= {"PYTHONPATH": str(at), "COVERAGE_FILE": str(folder / "coverage")}
    os.chdir(at)
    options = ["-n", "2", "--cov=cohesive", "--cov=meshing", "--cov-context=test", "--cov-report=", "--cov-append"]
    pytest.main([*options, *asked], plugins=[tests])
    file = folder / "durations.json"
    known = json.loads(file.read_text()) if file.exists() else {}
    known |= {name: seconds for name, seconds in tests.seconds.items() if name not in tests.failed}
    file.write_text(json.dumps(known, indent=0))


class Recorded:
    """Which tests execute a line of a file."""

    def __init__(self, folder: Path) -> None:
        from coverage import CoverageData

        self.seconds: dict[str, float] = json.loads((folder / "durations.json").read_text())
        self.data = CoverageData(str(folder / "coverage"))
        self.data.read()
        self.of_file: dict[str, dict[int, set[str]]] = {}

    def lines(self, file: str) -> dict[int, set[str]]:
        """Tests by line, "" for what runs on import."""
        if file not in self.of_file:
            name = next((each for each in self.data.measured_files() if each.endswith(f"/{file}")), "")
            found = self.data.contexts_by_lineno(name) if name else {}
            self.of_file[file] = {line: {text.rsplit("|", 1)[0] for text in tests} for line, tests in found.items()}
        return self.of_file[file]

    def tests(self, mutant: Mutant, budget: float) -> list[str]:
        """Tests to run, the cheapest first, up to a sum of seconds: those that execute the line, or the file if the line runs
        on import; then the others of their files, which may look at what one of them has prepared."""
        by_line = self.lines(mutant.file)
        near = {test for line in range(mutant.line, mutant.last + 1) for test in by_line.get(line, ())}
        if "" in near:
            near |= {test for tests in by_line.values() for test in tests}
        files = {test.split("::")[0] for test in near}
        others = {test for test in self.seconds if test.split("::")[0] in files} - near
        chosen, sum_of = [], 0.0
        for group in (near, others):
            for test in sorted(group & self.seconds.keys(), key=lambda test: self.seconds[test]):
                sum_of += self.seconds[test]
                if sum_of <= budget or not chosen:
                    chosen.append(test)
        return chosen


def run_tests(folder: Path, tests: list[str], limit: float) -> None:
    """In a process of its own: pytest, which ends it, with status 0 if all tests pass."""
    os.setsid()
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 1))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    with open(folder / "output.txt", "w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    for name in [name for name in sys.modules if name.split(".")[0] == "tests"]:
        del sys.modules[name]  # those of the copy count
    os.chdir(folder)
    os.environ |= {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", "OPENBLAS_NUM_THREADS": "1"}
    sys.path.insert(0, str(folder))
    sys.dont_write_bytecode = True
    status = 1
    try:
        status = pytest.main(["-x", "-n", "0", "-p", "no:cacheprovider", "--durations=0", "--tb=line", *tests])
    finally:
        os._exit(int(status))


def outcome_of(folder: Path, tests: list[str], seconds: float) -> str:
    """Of some tests in a copy of the package."""
    limit = SLOWER * seconds + BESIDES
    child = FORKS.Process(target=run_tests, args=(folder, tests, limit))
    child.start()
    child.join(10.0 * limit)
    if child.exitcode is None and child.pid is not None:
        os.killpg(child.pid, signal.SIGKILL)
        child.join()
    return {0: "survived", -signal.SIGXCPU: "timed out", -signal.SIGKILL: "timed out"}.get(child.exitcode or 0, "killed")


def sources() -> dict[str, bytes]:
    """Files that are changed, by their paths below the root."""
    paths = [str(path.relative_to(ROOT)) for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]
    return {path: (ROOT / path).read_bytes() for path in paths if not path.startswith(LEFT_OUT)}


def room_of(mutant: Mutant) -> str:
    return next(room for room in ROOMS if mutant.file.startswith(room))


@dataclass
class Trial:
    """Mutants on copies of the package, a process for each copy."""

    folder: Path
    recorded: Recorded
    sources: dict[str, bytes]
    equivalent: dict[str, str]
    budget: float

    def outcome(self, mutant: Mutant, copies: queue.Queue[Path]) -> str:
        if mutant.name in self.equivalent:
            return "equivalent"
        tests = self.recorded.tests(mutant, self.budget)
        if not tests:
            return "not covered"
        copy = copies.get()
        try:
            source = self.sources[mutant.file]
            (copy / mutant.file).write_bytes(mutant.applied(source))
            seconds = sum(self.recorded.seconds[test] for test in tests)
            return outcome_of(copy, tests, seconds)
        finally:
            (copy / mutant.file).write_bytes(source)
            copies.put(copy)

    def run(self, chosen: list[Mutant], processes: int) -> list[tuple[Mutant, str]]:
        """Outcomes, told as they come."""
        copies: queue.Queue[Path] = queue.Queue()
        for i in range(processes):
            copies.put(copied(self.folder / f"copy-{i}"))
        found = []
        with ThreadPoolExecutor(processes) as threads:
            waiting = {threads.submit(self.outcome, mutant, copies): mutant for mutant in chosen}
            for number, future in enumerate(as_completed(waiting), 1):
                mutant = waiting[future]
                found.append((mutant, future.result()))
                print(f"{number:4d} {future.result():11s} {mutant.line:4d} {mutant.name}", flush=True)
        return found


def told(found: list[tuple[Mutant, str]], equivalent: dict[str, str]) -> str:
    """Table by room, the survivors, and the equivalent ones with the reason."""
    lines = [f"{'':18s}" + "".join(f"{outcome:>13s}" for outcome in OUTCOMES) + f"{'killed, %':>13s}"]
    for room in (*ROOMS, ""):
        count = Counter(outcome for mutant, outcome in found if mutant.file.startswith(room))
        real = count.total() - count["equivalent"]
        share = 100.0 * (count["killed"] + count["timed out"]) / max(real, 1)
        lines.append(f"{room or 'all':18s}" + "".join(f"{count[outcome]:13d}" for outcome in OUTCOMES) + f"{share:13.1f}")
    for outcome in ("survived", "not covered", "equivalent"):
        some = [mutant for mutant, what in found if what == outcome]
        lines += ["", f"{outcome}:"] if some else []
        lines += [f"  line {each.line:3d} of {each.name}  {equivalent.get(each.name, '')}".rstrip() for each in some]
    return "\n".join(lines)


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--count", type=int, default=300, help="mutants to sample (default 300)")
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--only", default="", help="only mutants whose name contains this text, all of them")
    asked.add_argument("--again", action="store_true", help="those that survived the last trial only")
    asked.add_argument("--budget", type=float, default=60.0, help="recorded seconds of tests per mutant (default 60)")
    asked.add_argument("--processes", type=int, default=2)
    asked.add_argument("--folder", type=Path, default=Path("out/mutants"), help="for the copies and what is recorded")
    asked.add_argument("--record", nargs="*", help="record these tests, or all, before the trial")
    options = asked.parse_args()
    folder = options.folder.resolve()
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    if options.record is not None or not (folder / "durations.json").exists():
        record(folder, options.record or [])
    all_sources = sources()
    pool = [mutant for file, source in all_sources.items() for mutant in mutants(file, source)]
    survivors = folder / "survivors.json"
    if options.again:
        names = set(json.loads(survivors.read_text()))
        chosen = [mutant for mutant in pool if mutant.name in names]
    elif options.only:
        chosen = [mutant for mutant in pool if options.only in mutant.name]
    else:
        chosen = random.Random(options.seed).sample(pool, min(options.count, len(pool)))
    equivalent = tomllib.loads((ROOT / "tests/mutants.toml").read_text(encoding="utf-8"))
    found = Trial(folder, Recorded(folder), all_sources, equivalent, options.budget).run(chosen, options.processes)
    if not options.only:
        left = [mutant.name for mutant, what in found if what in ("survived", "not covered")]
        survivors.write_text(json.dumps(left, indent=0))
    print(f"\n{len(chosen)} of {len(pool)} mutants\n\n{told(found, equivalent)}")


if __name__ == "__main__":
    main()
