"""results/columns"""

from __future__ import annotations

COLUMNS = (
    "step", "load", "opening", "sliding", "driven", "stress_n", "stress_s", "work", "elastic", "stored", "dissipated",
    "contact_work", "iterations", "cuts", "residual", "wall_time", "stage",
)  # fmt: skip
