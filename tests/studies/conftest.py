"""Fixtures of the studies."""

from __future__ import annotations

import pytest


@pytest.fixture
def once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of a trade are not repeated for their times, which are not what is tested."""
    monkeypatch.setattr("cohesive.studies.trials.REPEATED", 0.0)
