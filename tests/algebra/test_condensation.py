"""Condensation, the choice between the condensed and the whole system, and steps by means of an older factorization."""

from __future__ import annotations

import tracemalloc
from itertools import product

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

import cohesive.algebra.bordered
import cohesive.algebra.choice
import cohesive.algebra.condensation
import cohesive.model.equations
import cohesive.simulation
from cohesive import Scene, run
from cohesive.algebra.bordered import Border, DenseStiffness, SparseStiffness
from cohesive.algebra.bulk_matrix import bulk_stiffness
from cohesive.algebra.condensation import NOT_HELD, Condensed, EliminationTree, runs
from cohesive.algebra.dissection import nested_dissection
from cohesive.elements.bulk import ElasticBlock, elasticity
from cohesive.model.build import build
from tests.builders import block, box

COARSE = {"mesh.crack_size": 5.0, "mesh.far_size": 20.0, "mesh.layers": 2, "stage.0.steps": 6, "output.frames": 0}


@pytest.fixture(scope="module")
def beam() -> Scene:
    return Scene.load("notched-beam-3d").with_(**COARSE)


def _box_to_condense(spring: float) -> tuple[sp.csc_array, EliminationTree, np.ndarray, np.ndarray]:
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
    group = nested_dissection(solid.points, [solid.cells], stay)[0][np.arange(K.shape[0]) // 3 % len(solid.points)]
    if not spring:
        group[-1] = 0
    order = np.argsort(group, kind="stable")
    start = np.unique(group[order], return_index=True)[1]
    lower = sp.tril(K[order][:, order], format="csc")
    return lower, EliminationTree.from_pattern(lower, start), order, K.toarray()


@pytest.mark.parametrize(
    "sizes",
    [{}, {"SMALL": 0, "LONG": 0}, {"SMALL": 0, "LONG": 10**9, "CHUNK": 50}],
    ids=["small ones", "large ones, by slices", "large ones, number by number"],
)
def test_fronts_give_the_schur_complement_and_the_way_back(sizes: dict[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in ({"BLOCK": 4} | sizes).items():  # a block is less than the 9 that stay
        monkeypatch.setattr(cohesive.algebra.condensation, name, value)
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
    recovered = condensed.recover(v)
    np.testing.assert_allclose(recovered, basis @ others, atol=1e-11 * abs(recovered).max())


def test_parts_that_touch_nothing_else() -> None:
    """Of a diagonal matrix: what is eliminated adds nothing to what is left, and does not move with it."""
    K, identity = sp.csc_array(np.diag([2.0, 3.0, 4.0, 5.0])), sp.eye_array(2, format="csr")
    condensed = Condensed.eliminate(K, EliminationTree.from_pattern(K, np.array([0, 1, 2])), identity, np.array([0, 1]))
    np.testing.assert_array_equal(condensed.stiffness, np.diag([4.0, 5.0]))
    np.testing.assert_array_equal(condensed.recover(np.array([0.1, -0.2])), [0.0, 0.0, 0.1, -0.2])


@pytest.mark.parametrize("seed", range(5))
def test_schur_complements_that_wait_do_not_share_memory(seed: int) -> None:
    """Also where they are not taken up in the order in which they were made, and some are never taken up."""
    rng, n = np.random.default_rng(seed), 60
    parents = [int(rng.integers(g + 1, n + 1)) for g in range(n)]
    parents = [-1 if parent == n else parent for parent in parents]
    borders = [np.arange(rng.integers(1, 9)) for _ in range(n)]
    places = EliminationTree(np.arange(n + 1), borders, parents).places
    for g in range(n):  # while that of g is made: those that it takes up are still there
        there = [i for i in range(g + 1) if parents[i] >= g or parents[i] == -1 or i == g]
        taken = [(places.stack[i], places.start[i] + j) for i in there for j in range(len(borders[i]) ** 2)]
        assert len(taken) == len(set(taken))
        assert all(place < places.sizes[stack] for stack, place in taken)


def test_counted_operations_are_those_of_the_fronts() -> None:
    """A full matrix in two groups: Cholesky's n^3 / 3 to the leading order, and all of its triangle's numbers."""
    n = 400
    full = sp.csc_array(np.tril(np.ones((n, n))))
    operations, numbers = EliminationTree.from_pattern(full, np.array([0, 150, n])).cost()
    assert operations == pytest.approx(n**3 / 3, rel=0.01)
    assert numbers == 150**2 + 150 * 250 + 250**2


def _tree(cells: np.ndarray, group: np.ndarray, order: np.ndarray) -> EliminationTree:
    """Of the nodes of hexahedra, with one unknown each, in an order by groups."""
    cell = np.repeat(np.arange(len(cells)), 8)
    shares = sp.coo_array((np.ones(len(cell)), (cell, cells.ravel()))).tocsc()
    start = np.append(np.unique(group[order], return_index=True)[1], len(order))
    return EliminationTree.from_pattern(sp.tril((shares.T @ shares).tocsc()[order][:, order], format="csc"), start)


@pytest.mark.parametrize(
    ("counts", "most"), [((60, 6, 6), 26e6), ((6, 60, 6), 26e6), ((6, 6, 60), 26e6), ((16, 16, 16), 160e6)]
)
def test_dissection_keeps_the_fronts_small(counts: tuple[int, int, int], most: float) -> None:
    """Measured 22 to 24e6 operations for a bar along any axis, 139e6 for a cube; 1000e6 where a bar is cut along, 29e6 and
    255e6 where the separators are eliminated in another order."""
    solid = box("hexahedron", counts, counts)
    group, _ = nested_dissection(solid.points, [solid.cells], np.zeros(0, dtype=np.int64))
    assert _tree(solid.cells, group, np.argsort(group, kind="stable")).cost()[0] < most


def test_what_a_group_takes_up_lies_in_long_runs() -> None:
    """Unknowns of a group by the parts beside them, in a mesh whose numbers tell nothing."""
    solid = box("hexahedron", (16, 16, 16), (16.0, 16.0, 16.0))
    number = np.random.default_rng(0).permutation(len(solid.points))
    points, cells = np.empty_like(solid.points), number[solid.cells]
    points[number] = solid.points
    group, beside = nested_dissection(points, [cells], np.zeros(0, dtype=np.int64))
    count = []
    for order in (np.lexsort((beside, group)), np.argsort(group, kind="stable")):
        tree = _tree(cells, group, order)
        count.append(0)
        for border, parent in zip(tree.borders, tree.parents, strict=True):
            if parent >= 0:
                later = border[border >= tree.start[parent + 1]]
                count[-1] += len(runs(np.searchsorted(tree.borders[parent], later)))
    assert count[0] < 0.5 * count[1]  # measured 2267 and 6359


def test_an_unknown_that_nothing_holds() -> None:
    lower, fronts, _, _ = _box_to_condense(spring=0.0)
    with pytest.raises(ValueError, match=NOT_HELD[:20]):
        Condensed.eliminate(lower, fronts, sp.eye_array(9, format="csr"), np.arange(9))


def test_a_body_held_by_no_more_than_rounding_is_not_held() -> None:
    """Of elements of 3e4 N/mm, by springs that all in all are 1e-12 of that, or 1e-8: a cantilever 1000 times as long as it
    is high has 2e-8, while the rounding of a body that nothing holds reaches 7e-13. In any unit of force."""
    for (spring, is_held), unit in product(((1e-10, False), (1e-6, True)), (1.0, 1e-9, 1e9)):
        lower, fronts, _, _ = _box_to_condense(spring)
        if is_held:
            Condensed.eliminate(unit * lower, fronts, sp.eye_array(9, format="csr"), np.zeros(0, dtype=np.int64))
            continue
        with pytest.raises(ValueError, match=NOT_HELD[:20]):
            Condensed.eliminate(unit * lower, fronts, sp.eye_array(9, format="csr"), np.zeros(0, dtype=np.int64))


def _tangents(n: int, number: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Diagonal springs, of which a few change from one to the next and turn negative."""
    rng = np.random.default_rng(4)
    values = rng.uniform(50.0, 60.0, n)
    changes = []
    for _ in range(number):
        values = values.copy()
        values[rng.integers(0, n, 5)] = rng.uniform(-1.0, 1.0, 5)
        changes.append((np.arange(n), np.arange(n), values))
    return changes


@pytest.mark.parametrize("kind", ["dense", "sparse"])
@pytest.mark.parametrize("held", [pytest.param(False, marks=pytest.mark.long), True], ids=["", "held across the drive"])
@pytest.mark.parametrize("control", ["motion", "measure", "load", "dissipation"])
def test_steps_by_an_older_factorization(kind: str, held: bool, control: str) -> None:
    """They solve the bordered system as well as its own factorization does, whatever controls it."""
    n = 2000  # a dense matrix of 2000 rows is worth eleven iterations
    K = sp.diags_array([np.full(n - 1, -1e3), np.full(n, 2e3 + 1.0), np.full(n - 1, -1e3)], offsets=[-1, 0, 1], format="csc")
    stiffness = DenseStiffness(K.toarray()) if kind == "dense" else SparseStiffness(K, np.arange(n), 30)
    load, rng, free = np.zeros(n), np.random.default_rng(5), sp.eye_array(n, format="csr")
    load[-1] = 1.0
    if held:  # the last two unknowns move along a direction
        at = np.arange(n), np.minimum(np.arange(n), n - 2)
        free = sp.csr_array((np.append(np.ones(n - 2), [0.6, 0.8]), at), shape=(n, n - 1))
        load[-2:] = 0.6, 0.8
    for crack in _tangents(n, 4):
        row, corner = {
            "motion": (load, 0.0),
            "measure": (1e-3 * rng.normal(size=n), 0.0),
            "load": (np.zeros(n), 1.0),
            "dissipation": (rng.normal(size=n), 0.0),
        }[control]
        right, last = 1e-2 * rng.normal(size=n), 0.3
        solution = stiffness.solve(Border(crack, load, row, corner, free if held else None), right, last)
        inner = free.T @ (K + sp.diags_array(crack[2])) @ free
        A = sp.block_array([[inner, -(free.T @ load)[:, None]], [(free.T @ row)[None], np.array([[corner]])]], format="csc")
        exact = spla.spsolve(A, np.append(free.T @ right, last))
        exact = np.append(free @ exact[:-1], exact[-1])
        # residual of 1e-6 in forces, the condition of the system in the step: measured below 1e-5
        np.testing.assert_allclose(solution, exact, atol=1e-4 * abs(exact).max())
        # the control counts as a force: measured below 2e-5, and 0.14 of a measure that does not
        assert row @ solution[:-1] + corner * solution[-1] == pytest.approx(last, rel=1e-4)
    made = stiffness.factorizations  # a row that is another one each time takes as long as half a factorization, or longer
    assert made == 1 or (made == 2 and control == "dissipation")
    many = np.append(right, last)[:, None] * [1.0, -2.0]
    anew = stiffness.factored(Border(crack, load, row, corner, free if held else None))(many)
    np.testing.assert_allclose(anew, exact[:, None] * [1.0, -2.0], atol=1e-9 * abs(exact).max())
    if held:  # another number of unknowns
        stiffness.solve(Border(crack, load, row, corner), right, last)
        assert stiffness.factorizations == made + 1


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
    stiffness.solve(Border((at, at, near), nothing, nothing, 1.0), right, 0.0)
    solution = stiffness.solve(Border((at, at, away), nothing, nothing, 1.0), right, 0.0)[:-1]
    # what any step keeps to: measured 40 where the size of the guess counted
    assert np.linalg.norm(K @ solution + away * solution - right) < 1e-6 * np.linalg.norm(right)


@pytest.mark.long
def test_an_older_factorization_changes_no_result(beam: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both kinds of stiffness, with one iteration of GMRES worth its while and with none."""
    exact = beam.with_(**{"solver.tol": 1e-11})
    results = {}
    for fewest in (1, 10**9):
        monkeypatch.setattr(cohesive.algebra.bordered, "FEWEST", fewest)
        monkeypatch.setattr(cohesive.algebra.bordered, "DENSE_WORTH", 2)
        for kind in ("always", "never"):
            results[fewest, kind] = run(exact.with_(**{"solver.condensation": kind}))
    reference = results[10**9, "always"]
    for result in results.values():
        for name in ("load", "opening", "dissipated"):
            size = abs(reference.history[name]).max()
            np.testing.assert_allclose(result.history[name], reference.history[name], atol=1e-9 * size)
        # six digits an iteration: at most one more in a step
        assert (result.history["iterations"] <= reference.history["iterations"] + 1).all()


def test_counted_memory_is_what_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a block whose crack is most of what there is, so that little but what is counted matters."""
    scene = Scene.load("single-crack-3d").with_(**{"mesh.crack_size": 8.0, "mesh.far_size": 40.0})
    bodies: list[cohesive.algebra.choice.Bulk] = []

    def caught(body: cohesive.algebra.choice.Bulk, wanted: str) -> cohesive.algebra.choice.Condensation:
        bodies.append(body)
        return cohesive.algebra.choice.condense(body, wanted)

    monkeypatch.setattr(cohesive.model.equations, "condense", caught)
    build(scene)
    part, whole = cohesive.algebra.choice.Part.from_bulk(bodies[0]), cohesive.algebra.choice.Whole.from_bulk(bodies[0])
    tracemalloc.start()
    condensed = part.condensed("")
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert condensed.kind == "condensed"
    # fronts on their way and lists come on top, a factor of the tangent is not there yet
    assert 0.8 * part.memory < taken < 1.1 * part.memory
    stiffness = whole.condensed("").stiffness
    assert isinstance(stiffness, SparseStiffness)
    K = sp.csc_array(stiffness.matrix + abs(bodies[0].operator).T @ abs(bodies[0].operator))[stiffness.order]
    factor = spla.splu(K[:, stiffness.order], permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    # it holds triangles where whole fronts are counted: measured 0.69
    assert 0.6 * whole.memory < 12.0 * (factor.L.nnz + factor.U.nnz) < whole.memory


def test_the_choice_and_its_reason(beam: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    model = build(beam)
    assert model.condensation.kind == "condensed" and model.condensation.why == ""  # nothing to weigh: 50 unknowns of 1000
    strip = build(block(specimen__height=1.0, mesh__crack_size=0.05, mesh__far_size=1.0))  # two rows beside its crack
    assert strip.condensation.kind == "whole" and "times the work" in strip.condensation.why
    monkeypatch.setattr(cohesive.algebra.choice, "LARGE", 1.0)
    result = run(beam)
    assert result.facts.condensation == "condensed" and "eliminated once (condensed " in result.summary()
    # where the dense matrix finds no room; where neither does, the smaller one: the beam's takes .46 MB, else 1.4 MB
    cracked = Scene.load("single-crack-3d").with_(**{"mesh.crack_size": 4.0, "mesh.far_size": 40.0})
    for scene, available, kind, hint in (
        (cracked, 0.075e9 / 0.6, "whole", False), (cracked, 0.01e9, "whole", True), (beam, 1e5, "condensed", True)
    ):  # fmt: skip
        monkeypatch.setattr(cohesive.algebra.choice, "machine_memory", lambda available=available: available)
        model = build(scene)
        assert model.condensation.kind == kind and ("'petsc'" in model.condensation.why) == hint
        assert scene is beam or model.condensation.why.startswith("condensed 0.097 GB, else 0.059 GB")
    assert build(beam.with_(**{"solver.condensation": "never"})).condensation.kind == "whole"  # the user's word counts
