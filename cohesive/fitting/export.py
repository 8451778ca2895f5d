"""A softening curve as input of other programs: Abaqus, DIANA, ATENA; units N and mm.

Sources. Abaqus keyword reference, *CONCRETE TENSION STIFFENING with TYPE=DISPLACEMENT (remaining stress, cracking
displacement) and *DAMAGE EVOLUTION with TYPE=DISPLACEMENT, SOFTENING=TABULAR (damage, displacement after its initiation).
DIANA user's manual, material library, smeared cracking: TENSIO 2 with pairs of stress and crack strain, whose last branch must
be given, and the crack bandwidth CRACKB. ATENA input file format, CC3DNonLinCementitious2User: the softening function is
sigma/ft over the fracturing strain, which is w over its characteristic size.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ..arrays import Array
from ..law.concrete import Concrete
from ..law.softening_choice import softening_name

#: largest distance between a curve and its points, over ft, and stress at which a curve without an end is cut, over ft
_CLOSE, _CUT = 2e-3, 1e-3

#: crack bandwidth that the strains of DIANA and ATENA are written for, mm
BAND = 10.0

#: thickness of the layer that the stiffness of Abaqus' cohesive elements stands for, mm
LAYER = 0.1


def points(concrete: Concrete) -> tuple[Array, Array]:
    """Openings (mm) and stresses (MPa) of a polyline that follows the curve to 0.2 % of ft, with its kinks and its end."""
    curve, unit = concrete.curve, float(concrete.Gf) / float(concrete.ft)
    end = float(curve.end)
    if not np.isfinite(end):
        end = unit
        while float(curve.stress(np.array([end]))[0]) > _CUT * concrete.ft:
            end *= 1.1
    w = [0.0, *getattr(curve, "kinks", ()), end]
    while True:
        middle = 0.5 * (np.array(w[1:]) + np.array(w[:-1]))
        stress = curve.stress(np.array(w))
        off = abs(curve.stress(middle) - 0.5 * (stress[1:] + stress[:-1])) > _CLOSE * float(concrete.ft)
        if not off.any() or len(w) > 200:
            break
        w = sorted([*w, *middle[off].tolist()])
    stress = curve.stress(np.array(w))
    stress[-1] = 0.0
    return np.array(w), np.asarray(stress)


def _abaqus(concrete: Concrete) -> str:
    w, stress = points(concrete)
    stiffness, shear = concrete.E / LAYER, concrete.G / LAYER
    start = float(concrete.ft) / stiffness
    damage = 1.0 - stress / (stiffness * (start + w))
    least = 1e-3 * float(concrete.ft)  # no zero stress in the table of concrete damaged plasticity
    lines = [
        f"** {_title(concrete)}, N and mm",
        "** concrete damaged plasticity: add *CONCRETE DAMAGED PLASTICITY and *CONCRETE COMPRESSION HARDENING",
        "*CONCRETE TENSION STIFFENING, TYPE=DISPLACEMENT",
        *(f"{max(s, least):.6g}, {x:.6g}" for x, s in zip(w, stress, strict=True)),
        f"** cohesive elements, a layer of {LAYER:g} mm: traction-separation",
        "*MATERIAL, NAME=CRACK",
        "*ELASTIC, TYPE=TRACTION",
        f"{stiffness:.6g}, {shear:.6g}, {shear:.6g}",
        "*DAMAGE INITIATION, CRITERION=MAXS",
        f"{concrete.ft:.6g}, {concrete.r_sigma * concrete.ft:.6g}, {concrete.r_sigma * concrete.ft:.6g}",
        "*DAMAGE EVOLUTION, TYPE=DISPLACEMENT, SOFTENING=TABULAR",
        *(f"{d:.8g}, {x:.6g}" for x, d in zip(w, damage, strict=True)),
    ]
    return "\n".join(lines) + "\n"


def _diana(concrete: Concrete) -> str:
    w, stress = points(concrete)
    pairs = [f"{s:.6g} {x / BAND:.6g}" for x, s in zip(w, stress, strict=True)] + ["0. 100000."]
    lines = [
        f": {_title(concrete)}, N and mm; crack strains for a bandwidth of {BAND:g} mm",
        "'MATERI'",
        f"   1  YOUNG  {concrete.E:.6g}",
        f"      POISON {concrete.nu:.6g}",
        "      CRACK  1",
        f"      CRKVAL {concrete.ft:.6g}",
        f"      CRACKB {BAND:g}",
        "      TENSIO 2",
        "      TENVAL " + "\n             ".join(pairs),
    ]
    return "\n".join(lines) + "\n"


def _atena(concrete: Concrete) -> str:
    w, stress = points(concrete)
    lines = [
        f"// {_title(concrete)}, N and mm",
        f"// tension function of CC3DNonLinCementitious2User, characteristic size {BAND:g} mm: E {concrete.E:.6g} MPa, "
        f"ft {concrete.ft:.6g} MPa",
        "// fracturing strain, sigma/ft",
        *(f"{x / BAND:.6g} {s / concrete.ft:.6g}" for x, s in zip(w, stress, strict=True)),
    ]
    return "\n".join(lines) + "\n"


def _title(concrete: Concrete) -> str:
    return f"softening curve ({softening_name(concrete.softening)}), ft {concrete.ft:.6g}, Gf {concrete.Gf:.6g}"


#: ending of the file and writer, by the name of the program
EXPORTS: Mapping[str, tuple[str, Callable[[Concrete], str]]] = {
    "abaqus": (".inp", _abaqus),
    "diana": (".dat", _diana),
    "atena": (".txt", _atena),
}
