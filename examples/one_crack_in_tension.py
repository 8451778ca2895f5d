"""One crack in tension: where does the energy go?

The built-in double-edge-notched plate is pulled apart to 0.1 mm and then pressed back to a mean stress of -3 MPa. The work
of the platen ends up in four places, and each is integrated on its own over the steps:

elastic       of the bulk, given back as the crack opens
stored        on the crack, by the part of it that is not damaged: (1 - omega) u.k.u / 2
dissipated    by damage, for good. A crack that opens all the way takes (Gf + ft^2 w/2E) x its area
contact work  of the faces on one another: none while the crack opens, and all that closing needs

None of the four is the remainder of the others, so that their sum is a check on the work.

Expected: sum and work within 0.1 % of the work; contact work below 1e-6 of it up to the turn, and positive after it.

    python -m examples.one_crack_in_tension [-o DIR]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command

PARTS = ("dissipated", "stored", "elastic", "contact_work")
TURN = 0.1  # mm


def main(size: float = 1.0, plot: Path | None = None) -> dict[str, float]:
    """Open and close the plate; print and return energies in N mm.

    Parameters
    ----------
    size : length of the elements on the crack, mm.
    plot : file for the figure.
    """
    scene = Scene.load("notched-tension").with_(
        **{"mesh.crack_size": size, "output.frames": 0},
        stage=[
            {"control": "opening", "to": 0.02, "steps": 40},
            {"control": "opening", "to": TURN, "step": 0.001, "unload": {"stress_n": -3.0}},
        ],
    )
    result = run(scene)
    h = result.history
    turn = int(h["opening"].argmax())
    out = {"peak load (N)": result.peak_load, "full energy (N mm)": float(result.full_energy or np.nan)}
    for where, row in (("turn", turn), ("end", -1)):
        out |= {f"{name}, {where}": float(h[name][row]) for name in ("work", *PARTS)}
    out["balance error"] = result.energy_error
    print(
        f"peak {result.peak_load:.0f} N at {result.opening_at_peak:.4f} mm; area x (Gf + ft^2 w/2E) = "
        f"{result.full_energy:.1f} N mm"
    )
    for where, row in (("turn", turn), ("end", -1)):
        parts = " + ".join(f"{name.replace('_', ' ')} {h[name][row]:.4g}" for name in PARTS)
        print(f"{where}, opening {h['opening'][row]:.4f} mm: work {h['work'][row]:.5g} = {parts} N mm")
    print(f"largest difference of work and sum: {out['balance error']:.1e} of the largest work")
    if plot is not None:
        _draw(result, turn, plot)
    return out


def _draw(result: Result, turn: int, path: Path) -> None:
    h = result.history
    figure = new_figure(10.0, 4.4)
    opens, closes = figure.subplots(1, 2, sharey=True, width_ratios=[1.4, 1.0])
    names = [name.replace("_", " ") for name in PARTS]
    for axes, rows in ((opens, slice(0, turn + 1)), (closes, slice(turn, None))):
        x = h["opening"][rows]
        axes.stackplot(x, [h[name][rows] for name in PARTS], labels=names, colors=["#e9a09a", "C1", "C0", "C2"])
        axes.plot(x, h["work"][rows], "k--", linewidth=1.4, label="work of the platen")
    opens.set(xlabel="opening (mm)", ylabel="energy (N mm)", title="opening", xlim=(0.0, TURN))
    closes.set(xlabel="opening (mm), decreasing", title="closing, to -3 MPa", xlim=(TURN, h["opening"][-1]))
    opens.legend(framealpha=1.0, loc="lower right")
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "one_crack_in_tension.png")
