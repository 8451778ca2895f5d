"""The outcome of a fit as its user sees it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .fit_report import save, summary
from .fitted import Fitted

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Fit(Fitted):
    """The outcome of a fit: its data (see `Fitted`), a summary in words, a figure and its files."""

    def summary(self) -> str:
        """The printed summary."""
        return summary(self)

    def plot(self) -> Figure:
        """Curve over data, residuals, and the softening curve with its band of confidence."""
        from .fit_figures import draw  # with matplotlib, which is slow to import

        return draw(self)

    def save(self, folder: str | Path) -> None:
        """Write fit.png, fit.csv, fit.json, the fitted scenes, and the softening curve as input of Abaqus, DIANA and ATENA.

        Raises
        ------
        SceneError
            If the folder cannot be written.
        """
        save(self, self.plot(), folder)
