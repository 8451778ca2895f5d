"""The data of a run."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive import Scene, run
from tests.builders import block


@pytest.mark.parametrize("model", ["discrete", "smeared"])
@pytest.mark.parametrize("quadrature", ["nodal", "gauss"])
def test_the_opening_profile_is_in_the_order_of_the_path(beam: Scene, model: str, quadrature: str) -> None:
    """The notch ends at 25 mm and the path goes up from there; the crack opens most at its mouth."""
    changes = {"mesh.order": 2, "interface.quadrature": quadrature, "model.kind": model, "stage.0.to": 0.05}
    result = run(beam.with_(**changes))
    for row in (0, -1):
        where, opening = result.opening_profile(row)
        assert (np.diff(where[:, 1]) >= 0).all() and len(opening) == len(where)
        np.testing.assert_allclose(result.profile_distance(), where[:, 1] - 25.0, atol=1e-9)
    assert (np.diff(opening) <= 1e-4).all()


def test_the_profile_follows_a_path_that_runs_backwards_and_bends() -> None:
    path = [[20.0, 0.0], [0.0, -6.0], [-20.0, 0.0]]
    result = run(block(specimen__crack=path, stage__0__steps=2, stage__0__to=0.01))
    where, _ = result.opening_profile(-1)
    assert (np.diff(where[:, 0]) <= 0).all()
    np.testing.assert_allclose(result.profile_distance(), (20.0 - where[:, 0]) * np.hypot(20.0, 6.0) / 20.0, atol=1e-9)
