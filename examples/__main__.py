"""Run all examples one after the other: `python -m examples [-o DIR]`; time, CPU time and peak memory of each."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

#: in reading order
EXAMPLES = (
    "law_at_a_point",
    "one_crack_in_tension",
    "width_matters",
    "opening_and_closing",
    "aggregate_interlock",
    "rubbing",
    "discrete_and_smeared",
    "size_effect",
    "crack_that_bends",
    "which_curve",
    "fibre_concrete",
    "shear_and_pull",
    "laboratory",
    "measured_deflection",
    "identification",
    "one_material",
    "found_path",
    "eccentric_beam",
    "many_paths",
    "accuracy",
    "sandwich_panel",
    "reinhardt",
    "jacobsen",
    "push_off",
    "push_off_3d",
    "closure_overshoot",
    "contact_smoothing",
    "as_printed",
    "corrected_contact",
    "growing_front",
    "extremes",
)


def main(folder: Path, names: tuple[str, ...] = EXAMPLES) -> int:
    """Run the examples, each in a process of its own; what they print goes to NAME.txt in `folder`. Number that failed."""
    folder.mkdir(parents=True, exist_ok=True)
    failed = 0
    print(f"{'example':24s}{'seconds':>9s}{'CPU s':>9s}{'MB':>7s}")
    for name in names:
        clock = time.perf_counter()
        with open(folder / f"{name}.txt", "w", encoding="utf-8") as out:
            process = subprocess.Popen([sys.executable, "-m", f"examples.{name}", "-o", str(folder)], stdout=out, stderr=out)
            _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        seconds, cpu = time.perf_counter() - clock, usage.ru_utime + usage.ru_stime
        memory = usage.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
        failure = f"  failed, see {folder / name}.txt" if process.returncode else ""
        print(f"{name:24s}{seconds:9.1f}{cpu:9.1f}{memory:7.0f}{failure}", flush=True)
        failed += bool(process.returncode)
    return failed


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("out"), help="folder for figures and printed numbers")
    sys.exit(1 if main(parser.parse_args().output) else 0)
