"""What a notebook shows: a result as a table with its curve, and the progress of a run."""

from __future__ import annotations

import sys
from base64 import b64encode
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING, Any

from ..results.measures import curve_measures, peak_text

if TYPE_CHECKING:
    from ..results.run_data import RunData
    from ..solver.stages import Stage


OnStep = Callable[[Any, dict[str, float]], None]


def html_of(data: RunData) -> str:
    """A small table, and the curve as a picture in the text."""
    measures, full = curve_measures(data), data.full_energy
    stiffness = measures.get("initial_stiffness")
    rows = [
        ("model", "crack band" if data.is_smeared else "discrete crack"),
        ("peak load", peak_text(data)),
        ("initial stiffness", "" if stiffness is None else f"{stiffness:.4g} N/mm over {measures['over']}"),
        ("dissipated", f"{data.dissipated_energy:.5g}{'' if full is None else f' of {full:.5g}'} N mm"),
        ("energy error", f"{data.energy_error:.1e} of the work"),
        ("steps, iterations", f"{data.steps}, {data.iterations}"),
        ("unknowns", f"{data.active_dofs} of {data.total_dofs}"),
        *(("note", note) for note in data.notes),
    ]
    table = "".join(f"<tr><th style='text-align:left'>{escape(k)}</th><td>{escape(v)}</td></tr>" for k, v in rows if v)
    picture = f"<img alt='curve' src='data:image/png;base64,{_curve(data)}'>" if data.steps else "no step converged"
    return f"<div><strong>{escape(data.scene.title)}</strong><table>{table}</table>{picture}</div>"


def _curve(data: RunData) -> str:
    """The curve as PNG in base 64."""
    from ..figures.drawing import draw_curve, new_figure, save  # with matplotlib, which is slow to import

    figure, png = new_figure(5.4, 3.4), BytesIO()
    draw_curve(figure.add_subplot(), data)
    save(figure, png, dpi=90)
    return b64encode(png.getvalue()).decode()


def is_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return type(shell).__name__ == "ZMQInteractiveShell"


@contextmanager
def notebook_progress(stages: Sequence[Stage], given: OnStep | None = None) -> Iterator[OnStep | None]:
    """What is called after each step: what is given, else what moves a bar below the cell; None if this is no notebook."""
    if given is not None or not is_notebook():
        yield given
        return
    from tqdm.auto import tqdm  # with the widgets of the notebook, if they are there

    from ..solver.stages import expected_steps

    with tqdm(total=expected_steps(stages), unit="step", leave=False) as bar:

        def on_step(step: Any, row: dict[str, float]) -> None:
            bar.update()
            bar.set_postfix_str(f"{step.control} {step.value:.4g}, load {row['load']:.4g} N")

        yield on_step
