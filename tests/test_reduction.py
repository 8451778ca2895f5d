"""Condensation, the choice between the condensed and the whole system, and steps by means of an older factorization."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import cohesive.condensation
import cohesive.linear
import cohesive.reduction
from cohesive import Scene, run
from cohesive.assembly import bulk_stiffness
from cohesive.condensation import NOT_HELD, Condensed, Fronts
from cohesive.continuum import ElasticBlock, elasticity
from cohesive.dissection import nested_dissection
from cohesive.linear import DenseStiffness, NotConverged, SparseStiffness
from cohesive.simulation import build
from tests.solids import box

COARSE = {"mesh.crack_size": 5.0, "mesh.far_size": 20.0, "mesh.layers": 2, "stage.0.steps": 6, "output.frames": 0}


@pytest.fixture(scope="module")
def beam() -> Scene:
    return Scene.load("notched-beam-3d").with_(**COARSE)


def _box_to_condense(spring: float) -> tuple[sp.csc_array, Fronts, np.ndarray, np.ndarray]:
    """Stiffness of a box on springs (N/mm) at all its nodes, in the order of elimination; its last 3 nodes stay. Without
    springs there is an unknown more that nothing holds."""
    solid = box("hexahedron", (7, 5, 4), (7.0, 5.0, 4.0))
    n = solid.points.size
    block = ElasticBlock(solid.kind, solid.points, solid.cells, elasticity(3e4, 0.2, None))
    K = bulk_stiffness([block], n).tocsc()
    if spring:
        K = K + spring * sp.eye_array(n, format="csc")
    else:
        K = sp.block_diag([K, np.zeros((1, 1))], format="csc")
    stay = np.array([0, 1, 2])
    group = nested_dissection(solid.points, [solid.cells], stay)[np.arange(K.shape[0]) // 3 % len(solid.points)]
    if not spring:
        group[-1] = 0
    order = np.argsort(group, kind="stable")
    start = np.unique(group[order], return_index=True)[1]
    lower = sp.tril(K[order][:, order], format="csc")
    return lower, Fronts.of(lower, start), order, K.toarray()


def test_fronts_give_the_schur_complement_and_the_way_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cohesive.condensation, "_BLOCK", 4)  # less than the 9 that stay
    lower, fronts, order, K = _box_to_condense(spring=1e3)
    first = fronts.start[-1]
    turn = np.random.default_rng(2).normal(size=(len(order) - first, len(order) - first))
    active = np.array([1, 4, 5, 7])
    condensed = Condensed.eliminate(lower, fronts, sp.csr_array(turn), active)
    # the same with all unknowns that stay as combinations of others, by dense algebra
    basis = np.eye(len(order))
    basis[first:, first:] = turn
    whole = basis.T @ K[np.ix_(order, order)] @ basis
    kept = first + active
    gone = np.setdiff1d(np.arange(len(order)), kept)
    back = -np.linalg.solve(whole[np.ix_(gone, gone)], whole[np.ix_(gone, kept)])
    expected = whole[np.ix_(kept, kept)] + whole[np.ix_(kept, gone)] @ back
    # rounding, amplified by the condition of the turn, about 1e2 squared
    np.testing.assert_allclose(condensed.stiffness, expected, atol=1e-11 * abs(expected).max())
    v = np.array([0.3, -0.1, 0.7, 1.1])
    others = np.empty(len(order))
    others[kept], others[gone] = v, back @ v
    found = condensed.recover(v)
    np.testing.assert_allclose(found, basis @ others, atol=1e-11 * abs(found).max())


def test_counted_operations_are_those_of_the_fronts() -> None:
    """A full matrix in two groups: Cholesky's n^3 / 3 to the leading order, and all of its triangle's numbers."""
    n = 400
    full = sp.csc_array(np.tril(np.ones((n, n))))
    operations, numbers = Fronts.of(full, np.array([0, 150, n])).cost()
    assert operations == pytest.approx(n**3 / 3, rel=0.01)
    assert numbers == 150**2 + 150 * 250 + 250**2


def test_an_unknown_that_nothing_holds() -> None:
    lower, fronts, _, _ = _box_to_condense(spring=0.0)
    with pytest.raises(ValueError, match=NOT_HELD[:20]):
        Condensed.eliminate(lower, fronts, sp.eye_array(9, format="csr"), np.arange(9))


def test_a_body_held_by_no_more_than_rounding_is_not_held() -> None:
    """Of elements of 3e4 N/mm, by springs that all in all are 1e-12 of that, or 1e-8: a cantilever 1000 times as long as it
    is high has 2e-8, while the rounding of a body that nothing holds reaches 7e-13."""
    for spring, is_held in ((1e-10, False), (1e-6, True)):
        lower, fronts, _, _ = _box_to_condense(spring)
        if is_held:
            Condensed.eliminate(lower, fronts, sp.eye_array(9, format="csr"), np.zeros(0, dtype=np.int64))
            continue
        with pytest.raises(ValueError, match=NOT_HELD[:20]):
            Condensed.eliminate(lower, fronts, sp.eye_array(9, format="csr"), np.zeros(0, dtype=np.int64))


def _tangents(n: int, number: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Diagonal springs, of which a few change from one to the next and turn negative."""
    rng = np.random.default_rng(4)
    values = rng.uniform(50.0, 60.0, n)
    found = []
    for _ in range(number):
        values = values.copy()
        values[rng.integers(0, n, 5)] = rng.uniform(-1.0, 1.0, 5)
        found.append((np.arange(n), np.arange(n), values))
    return found


@pytest.mark.parametrize("kind", ["dense", "sparse"])
@pytest.mark.parametrize("control", ["motion", "load", "dissipation"])
def test_steps_by_an_older_factorization(kind: str, control: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """They solve the bordered system as well as its own factorization does, whatever controls it."""
    n = 1200
    K = sp.diags_array([np.full(n - 1, -1e3), np.full(n, 2e3 + 1.0), np.full(n - 1, -1e3)], offsets=[-1, 0, 1], format="csc")
    stiffness: DenseStiffness | SparseStiffness
    stiffness = DenseStiffness(K.toarray()) if kind == "dense" else SparseStiffness(K, np.arange(n), 30)
    made = []
    factor = type(stiffness)._factor

    def counted(self: Any, *arguments: Any) -> Any:
        made.append(arguments)
        return factor(self, *arguments)

    monkeypatch.setattr(type(stiffness), "_factor", counted)
    load, rng = np.eye(n)[-1], np.random.default_rng(5)
    for crack in _tangents(n, 4):
        row, corner = {
            "motion": (load, 0.0),
            "load": (np.zeros(n), 1.0),
            "dissipation": (rng.normal(size=n), 0.0),
        }[control]
        right, last = 1e-2 * rng.normal(size=n), 0.3
        found = stiffness.solve(crack, load, row, corner, right, last)
        A = np.block([[K.toarray() + np.diag(crack[2]), -load[:, None]], [row[None], np.array([[corner]])]])
        exact = np.linalg.solve(A, np.append(right, last))
        # residual of 1e-6 in forces, the condition of the system in the step: measured below 1e-5
        np.testing.assert_allclose(found, exact, atol=1e-4 * abs(exact).max())
    assert len(made) == 1


def test_a_system_that_changed_too_much_is_factored_anew() -> None:
    n = 1200
    K = sp.diags_array([np.full(n - 1, -1e3), np.full(n, 2e3 + 1.0), np.full(n - 1, -1e3)], offsets=[-1, 0, 1]).toarray()
    stiffness, at, e = DenseStiffness(K), np.arange(n), np.eye(n)[-1]
    rng = np.random.default_rng(6)
    for _ in range(2):
        springs = 10.0 ** rng.uniform(0, 6, n)
        right = 1e3 * rng.normal(size=n)
        found = stiffness.solve((at, at, springs), e, e, 0.0, right, 1.0)
        A = np.block([[K + np.diag(springs), -e[:, None]], [e[None], np.zeros((1, 1))]])
        # each with its own factorization: the rounding of one
        np.testing.assert_allclose(found, np.linalg.solve(A, np.append(right, 1.0)), rtol=1e-8, atol=1e-10)
    for either in (stiffness, SparseStiffness(sp.csc_array(K), at, 30)):
        with pytest.raises(NotConverged, match="singular"):  # nothing controls the load
            either.solve((at[:0], at[:0], np.zeros(0)), np.zeros(n), np.zeros(n), 0.0, np.ones(n), 0.0)


@pytest.mark.parametrize("kind", ["dense", "sparse"])
def test_a_factorization_near_a_limit_point_serves_no_other_step(kind: str) -> None:
    """One spring all but takes away what holds: the guess from there is 1e8 times too large, and so are its forces."""
    n = 1200
    K = sp.diags_array([np.full(n - 1, -1e3), np.full(n, 2e3 + 1.0), np.full(n - 1, -1e3)], offsets=[-1, 0, 1], format="csc")
    stiffness = DenseStiffness(K.toarray()) if kind == "dense" else SparseStiffness(K, np.arange(n), 30)
    at, nothing, rng = np.arange(n), np.zeros(n), np.random.default_rng(1)
    limit = -1.0 / np.linalg.inv(K.toarray())[600, 600]
    right = 1e-2 * rng.normal(size=n)
    near, away = nothing.copy(), nothing.copy()
    near[600], away[600] = (1.0 - 1e-8) * limit, 0.5 * limit
    away[100:1000:9] += rng.uniform(0.0, 3e3, 100)
    stiffness.solve((at, at, near), nothing, nothing, 1.0, right, 0.0)
    found = stiffness.solve((at, at, away), nothing, nothing, 1.0, right, 0.0)[:-1]
    # what any step keeps to: measured 40 where the size of the guess counted
    assert np.linalg.norm(K @ found + away * found - right) < 1e-6 * np.linalg.norm(right)


def test_an_older_factorization_changes_no_result(beam: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both kinds of stiffness, with one iteration of GMRES worth its while and with none."""
    exact = beam.with_(**{"solver.tol": 1e-11})
    found = {}
    for fewest in (1, 10**9):
        monkeypatch.setattr(cohesive.linear, "_FEWEST", fewest)
        monkeypatch.setattr(cohesive.linear, "_DENSE_WORTH", 2)
        for kind in ("condensed", "none"):
            found[fewest, kind] = run(exact.with_(**{"solver.reduction": kind}))
    reference = found[10**9, "condensed"]
    for result in found.values():
        for name in ("load", "opening", "dissipated"):
            size = abs(reference.history[name]).max()
            np.testing.assert_allclose(result.history[name], reference.history[name], atol=1e-9 * size)
        # six digits an iteration: at most one more in a step
        assert (result.history["iterations"] <= reference.history["iterations"] + 1).all()


def test_the_choice_and_its_reason(beam: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    model = build(beam)
    assert model.reduced.kind == "condensed" and model.reduced.why == ""  # nothing to weigh: 50 unknowns of 1000
    monkeypatch.setattr(cohesive.reduction, "_SPARSE_IS_SLOWER", 1e-4)
    model = build(beam)
    assert model.reduced.kind == "none" and "times the work" in model.reduced.why
    monkeypatch.setattr(cohesive.reduction, "_SPARSE_IS_SLOWER", 10.0)
    monkeypatch.setattr(cohesive.reduction, "_LARGE", 1.0)
    result = run(beam)
    assert result.model.reduced.kind == "condensed" and "eliminated once (condensed " in result.summary()
    # where the dense matrix finds no room; where neither does, the smaller one
    part, whole = cohesive.reduction._Part, cohesive.reduction._Whole
    monkeypatch.setattr(part, "memory", property(lambda self: 2e9))
    monkeypatch.setattr(whole, "memory", property(lambda self: 1e9))
    for available, hint in ((1.5e9 / 0.6, False), (1e8, True)):
        monkeypatch.setattr(cohesive.reduction, "_memory", lambda available=available: available)
        model = build(beam)
        assert model.reduced.kind == "none" and model.reduced.why.startswith("condensed 2 GB, else 1 GB")
        assert ("'petsc'" in model.reduced.why) == hint
    monkeypatch.setattr(part, "memory", property(lambda self: 5e8))
    assert build(beam).reduced.kind == "condensed"
    assert build(beam.with_(**{"solver.reduction": "none"})).reduced.kind == "none"  # the user's word counts
