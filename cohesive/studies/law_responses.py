"""Responses of the law at a point: the paper's Figures 10, 11 and 26, the contact surface, and softening curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..law.concrete import Concrete
from ..law.crack_plane import CrackPlane
from ..law.softening import SOFTENING
from ..law.softening_branches import fully_softened
from ..law.softening_choice import curve_of, fixes_strength, normalized, softening_name, strength_and_energy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: openings of Figure 11 over the Zm of its material (0.2 mm): 0.06 and 0.122 mm there
HELD_OPENINGS = (0.30, 0.61)

#: closing parameters of Figure 26
CLOSING = (5.0, 9.0, 50.0)


def follow(law: CrackPlane, path: Array) -> tuple[Array, Array]:
    """Tractions (n, 2) and histories (n,) along a path of jumps (n, 2), from the intact state."""
    tractions, histories = np.empty_like(path), np.empty(len(path))
    Z = np.array([law.Zt])
    for i, jump in enumerate(path):
        traction, Z = law.traction(jump[None], Z)
        tractions[i], histories[i] = traction[0], Z[0]
    return tractions, histories


def _to_and_fro(*turns: float, points: int = 200) -> Array:
    legs = [np.linspace(a, b, points) for a, b in pairwise(turns)]
    return np.concatenate(legs)


def cyclic_tension(law: CrackPlane) -> Array:
    """Opening, closing and reopening (Figure 10): columns jump_n, traction_n, history."""
    Zm = law.concrete.Zm
    u = _to_and_fro(0.0, 0.1 * Zm, -0.005 * Zm, 0.3 * Zm, -0.005 * Zm, 0.6 * Zm, -0.005 * Zm, 1.0 * Zm)
    t, Z = follow(law, np.stack([u, np.zeros_like(u)], axis=1))
    return np.stack([u, t[:, 0], Z], axis=1)


def held_shear(law: CrackPlane, opening: float) -> Array:
    """Opened, then sheared at constant opening (Figure 11): columns jump_s, traction_n, traction_s, history."""
    s = np.linspace(0.0, 1.5 * law.concrete.Zm, 400)
    opened = np.stack([np.linspace(0.0, opening, 50), np.zeros(50)], axis=1)
    t, Z = follow(law, np.concatenate([opened, np.stack([np.full_like(s, opening), s], axis=1)]))
    return np.stack([s, t[50:, 0], t[50:, 1], Z[50:]], axis=1)


def closing(law: CrackPlane, c_zn: float) -> Array:
    """Opened to 0.25 Zm and closed (Figure 26): columns jump_n, traction_n."""
    changed = CrackPlane(replace(law.concrete, c_zn=c_zn), law.width)
    Zm = law.concrete.Zm
    u = _to_and_fro(0.0, 0.25 * Zm, -0.05 * Zm)
    return np.stack([u, follow(changed, np.stack([u, np.zeros_like(u)], axis=1))[0][:, 0]], axis=1)


def tables(law: CrackPlane) -> dict[str, tuple[str, Array]]:
    """All curves by name, each with the header of its columns."""
    Zm = law.concrete.Zm
    result = {"cyclic_tension": ("jump_n_mm,traction_n_MPa,Z_mm", cyclic_tension(law))}
    for part in HELD_OPENINGS:
        name = f"shear_at_{part * Zm:.4g}_mm"
        result[name] = ("jump_s_mm,traction_n_MPa,traction_s_MPa,Z_mm", held_shear(law, part * Zm))
    for c_zn in CLOSING:
        result[f"closing_c_zn_{c_zn:g}"] = ("jump_n_mm,traction_n_MPa", closing(law, c_zn))
    return result


def save_figure(law: CrackPlane, path: Path) -> None:
    """The four panels as PNG."""
    from ..figures.drawing import new_figure, save, set_title

    figure = new_figure(10.0, 8.0)
    axes = figure.subplots(2, 2)
    m, curves = law.concrete, tables(law)
    set_title(
        figure,
        f"Young's modulus E = {m.E:g} MPa, tensile strength ft = {m.ft:g} MPa, fracture energy Gf = {m.Gf:g} N/mm,",
        f"length of the asperities Zm = {m.Zm:.3g} mm, width of the crack plane {law.width:.3g} mm",
    )
    cyclic = curves["cyclic_tension"][1]
    axes[0, 0].plot(cyclic[:, 0], cyclic[:, 1], color="C0")
    axes[0, 0].set(title="opening and closing", xlabel="jump, normal (mm)", ylabel="traction, normal (MPa)")
    axes[0, 0].set_ylim(-1.5 * m.ft, 1.2 * m.ft)
    for i, part in enumerate(HELD_OPENINGS):
        shear = curves[f"shear_at_{part * m.Zm:.4g}_mm"][1]
        label = f"held at {part * m.Zm:.3g} mm"
        axes[0, 1].plot(shear[:, 0], shear[:, 2], color=f"C{i}", label=f"shear, {label}")
        axes[0, 1].plot(shear[:, 0], shear[:, 1], "--", color=f"C{i}", label=f"normal, {label}")
    axes[0, 1].set(title="shear at constant opening", xlabel="jump, shear (mm)", ylabel="traction (MPa)")
    axes[0, 1].legend(frameon=False, fontsize=8)
    for c_zn in CLOSING:
        curve = curves[f"closing_c_zn_{c_zn:g}"][1]
        axes[1, 0].plot(curve[:, 0], curve[:, 1], label=f"c_zn = {c_zn:g}")
    axes[1, 0].set(
        title="closing; a small c_zn smooths the contact", xlabel="jump, normal (mm)", ylabel="traction, normal (MPa)"
    )
    axes[1, 0].set_ylim(-1.2 * m.ft, 1.2 * m.ft)
    axes[1, 0].legend(frameon=False, fontsize=8)
    _contact_surface(law, axes[1, 1])
    for panel in axes.flat:
        panel.locator_params(axis="x", nbins=6)
    for panel in axes.flat[:3]:
        panel.axhline(0.0, color="0.5", linewidth=0.6)
    save(figure, path)


def _contact_surface(law: CrackPlane, axes: Axes) -> None:
    """Contours of phi in the (u1, s) plane of a fully grown crack."""
    Zm = law.concrete.Zm
    u, s = np.meshgrid(np.linspace(-0.3, 1.2, 241) * Zm, np.linspace(-1.5, 1.5, 481) * Zm)
    Z = np.full(u.size, Zm)
    phi, _ = law.contact_distance(np.stack([u.ravel(), s.ravel()], axis=1), Z)
    phi = phi.reshape(u.shape)
    reach = float(law.contact_reach(Z[:1])[0])
    levels = np.array([-1.0, -0.8, -0.6, -0.4, -0.2, 0.2, 0.6]) * Zm
    lines = axes.contour(u, s, phi, levels, cmap="coolwarm_r", linewidths=0.8)
    axes.clabel(lines, fontsize=7, fmt="%.2g")
    axes.contour(u, s, phi, [0.0], colors="k", linewidths=1.6)
    axes.contour(u, s, phi, [reach], colors="k", linewidths=1.2, linestyles="--")
    axes.plot([], [], "k", label="surfaces touch: phi = 0")
    axes.plot([], [], "k--", label="asperities begin to touch: phi = ulm")
    axes.legend(frameon=True, fontsize=8, loc="lower left")
    axes.set(title="distance phi (mm) from contact, crack fully grown", xlabel="jump, normal (mm)", ylabel="jump, shear (mm)")


def softening_curves(concrete: Concrete, softening: Sequence[Any] = tuple(SOFTENING)) -> dict[str, Array]:
    """Softening curves by name, each (n, 2): opening beyond the onset in mm, stress in MPa, with the kinks and the end.

    Named curves and kinks have the ft and Gf of `concrete`, points and objects their own. A curve without an end is followed
    to 6 Gf/ft.

    Raises
    ------
    ValueError
        For what is no softening curve, see `Concrete`.
    """
    result = {}
    for choice in map(normalized, softening):
        ft, Gf = strength_and_energy(choice) if fixes_strength(choice) else (concrete.ft, concrete.Gf)
        curve = curve_of(choice, ft, Gf)
        last = curve.end if np.isfinite(curve.end) else min(fully_softened(curve), 6.0 * Gf / ft)
        w = np.unique(np.concatenate([last * np.linspace(0.0, 1.0, 200) ** 2, getattr(curve, "kinks", ())]))
        result[softening_name(choice)] = np.stack([w, curve.stress(w)], axis=1)
    return result


def draw_softening(axes: Axes, concrete: Concrete, softening: Sequence[Any] = tuple(SOFTENING)) -> None:
    """Stress over opening of several softening curves side by side, see `softening_curves`."""
    for name, curve in softening_curves(concrete, softening).items():
        axes.plot(curve[:, 0], curve[:, 1], label=name)
    axes.axhline(0.0, color="0.5", linewidth=0.6)
    axes.set(title="softening", xlabel="opening beyond the onset (mm)", ylabel="stress (MPa)")
    axes.legend(frameon=False, fontsize=8)


def save_softening_figure(concrete: Concrete, path: Path, softening: Sequence[Any] = tuple(SOFTENING)) -> None:
    """The curves of `draw_softening` as PNG."""
    from ..figures.drawing import new_figure, save

    figure = new_figure(6.0, 4.2)
    draw_softening(figure.subplots(), concrete, softening)
    save(figure, path)
