"""The names of the history's columns, in the order of history.csv."""

from __future__ import annotations

COLUMNS = (
    "step", "load", "opening", "sliding", "driven", "stress_n", "stress_s", "work", "elastic", "stored", "dissipated",
    "contact_work", "iterations", "cuts", "residual", "wall_time", "stage",
)  # fmt: skip
