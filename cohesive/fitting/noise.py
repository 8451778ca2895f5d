"""Noise of gauge and load cell from the residuals of a fit, and the weights that follow.

A row that was measured at x + e_x as y + e_y leaves the residual L(x + e_x) - y - e_y, to first order with the variance
s_y^2 + L'(x)^2 s_x^2, L' the slope of the model (effective variance: Orear, Am. J. Phys. 50 (1982) 912). What the model cannot
follow is common to neighbouring rows. So noise is estimated from the differences of each residual from the mean of its
neighbours; beside it stands a variance of the pieces, t^2, with which the weighted sum of squares is what their number lets
expect (Paule and Mandel, J. Res. NBS 87 (1982) 377). The weights are those of means over pieces, 1/(t^2 + v),
1/v = sum of 1/(s_y^2 + L'^2 s_x^2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from .data import Data, means

#: rows from which on noise is estimated
_ROWS = 30

#: twice the rise of the log-likelihood that noise of a gauge must bring: one time of a thousand it does by chance, and
#: neighbouring differences share rows, which makes them worth two thirds
_SEEN = 10.8 * 1.5

#: least standard deviation of a load, part of the peak: files have digits
_LEAST = 1e-6

#: misfit from which on another curve is named, part of the peak
_FOLLOWED = 0.01

#: logarithms of the noise that the gauge brings to the load where it is steepest over that of the load, both squared
_POWERS = np.linspace(-6.0, 20.0, 27)


@dataclass(frozen=True)
class Noise:
    """Standard deviations.

    Attributes
    ----------
    opening : of the motion, mm; 0 if the rows do not show it
    load : of the load, N
    misfit : of what the model does not follow, N
    """

    opening: float
    load: float
    misfit: float

    def words(self, against: str, peak: float) -> str:
        """One sentence."""
        motion = f"{1e3 * self.opening:.2g} um in {against}" if self.opening else f"none seen in {against}"
        return (
            f"noise: {motion}, {self.load:.3g} N in the load; beside it the model leaves "
            f"{100 * self.misfit / peak:.2g} % of the peak"
            + (", which another softening curve may follow (--softening)" if self.misfit > _FOLLOWED * peak else "")
        )


def weighed(data: Data, load: Array, slope: Array, numbers: int) -> tuple[Data, Noise] | None:
    """Data whose pieces weigh what noise and misfit leave them; None for few rows, a band or another loss.

    Parameters
    ----------
    load, slope : (n,) arrays, the computed load and its slope in x at the rows, N and N/mm
    numbers : how many are fitted
    """
    if data.loss != "linear" or len(data.x) < _ROWS:
        return None
    residuals = load - data.middle
    opening, of_load = _noise(data, residuals, slope)
    variance = of_load + slope**2 * opening
    gather = means(data.piece, 1.0 / variance)
    of_piece = 1.0 / np.bincount(data.piece, 1.0 / variance)
    left = gather @ residuals
    misfit = _misfit(left, of_piece, len(left) - numbers)
    root = np.sqrt(1.0 / (misfit + of_piece))
    root /= np.sqrt(np.mean(root**2))
    noise = Noise(float(np.sqrt(opening)), float(np.sqrt(of_load)), float(np.sqrt(misfit)))
    return replace(data, gather=gather.multiply(root[:, None]).tocsr()), noise


def _noise(data: Data, residuals: Array, slope: Array) -> tuple[float, float]:
    """Variances of motion and load, mm^2 and N^2, by maximum likelihood from the second differences of the residuals."""
    from scipy.optimize import minimize_scalar  # slow to import

    inner = np.flatnonzero(data.curve[2:] == data.curve[:-2]) + 1
    squares = np.maximum(np.square(residuals[inner] - 0.5 * (residuals[inner - 1] + residuals[inner + 1])), 1e-300)
    steep = np.square(slope / abs(slope).max())
    terms = 1.5, steep[inner] + 0.25 * (steep[inner - 1] + steep[inner + 1])
    least = (_LEAST * data.peak) ** 2

    def of_load(ratio: float) -> float:
        return max(float(np.mean(squares / (terms[0] + ratio * terms[1]))), least)

    def unlikely(power: float) -> float:
        variance = of_load(np.exp(power)) * (terms[0] + np.exp(power) * terms[1])
        return float(np.sum(np.log(variance) + squares / variance))

    best = min(_POWERS, key=unlikely)
    step = _POWERS[1] - _POWERS[0]
    best = float(minimize_scalar(unlikely, bounds=(best - step, best + step), method="bounded").x)
    if unlikely(-np.inf) - unlikely(best) < _SEEN:
        return 0.0, of_load(0.0)
    ratio = float(np.exp(best))
    return ratio * of_load(ratio) / float(np.square(slope).max()), of_load(ratio)


def _misfit(left: Array, variance: Array, freedom: int) -> float:
    """The variance t^2, N^2, with which the sum of left^2/(t^2 + variance) is the number of degrees of freedom; at least 0."""
    from scipy.optimize import brentq  # slow to import

    def over(added: float) -> float:
        return float(np.sum(left**2 / (added + variance))) - max(freedom, 1)

    return 0.0 if over(0.0) <= 0.0 else float(brentq(over, 0.0, float(np.sum(left**2))))


def sentences(data: Sequence[Data], noises: Sequence[Noise | None]) -> list[str]:
    """What is said of the noise of each scene that shows any."""
    several = len(data) > 1
    return [
        (f"{each.curves[0].name}: " if several else "") + noise.words(each.against, each.peak)
        for each, noise in zip(data, noises, strict=True)
        if noise is not None
    ]
