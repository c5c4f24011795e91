"""The native solver and Clarabel answer alike, and as one would by hand."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.kernel.native import native
from planning.refine.model.penalty_qp import _NO_BALLS, _NO_PRODUCTS, PenaltyQp
from planning.refine.model.penalty_rows import BallRows, PenaltyRows, ProductRows
from tests.profiles import num_cases

NATIVELY = pytest.mark.parametrize("natively", [True, False])


def random_program(seed: int, num_variables: int, num_rows: int) -> PenaltyQp:
    rng = np.random.default_rng(seed)
    columns = np.sort(rng.integers(-1, num_variables, (num_rows, 3)), axis=1)
    columns[:, 1:][np.diff(columns, axis=1) == 0] = -1
    wide = rng.integers(0, num_variables, (4, 1)) + np.zeros((4, 1), dtype=int)
    return PenaltyQp(
        rng.normal(size=num_variables),
        np.full(num_variables, 1e-2),
        -rng.uniform(0.1, 2, num_variables),
        rng.uniform(0.1, 2, num_variables),
        (
            PenaltyRows(columns, rng.normal(size=columns.shape), rng.normal(size=num_rows), 0.7),
            PenaltyRows(wide, np.ones(wide.shape), np.full(4, 0.5), 5.0),
        ),
    )


@settings(max_examples=num_cases(6))
@given(
    seed=st.integers(0, 2**32 - 1), num_variables=st.integers(1, 30), num_rows=st.integers(1, 80)
)
def test_both_find_the_least_cost(seed, num_variables, num_rows):
    program = random_program(seed, num_variables, num_rows)
    ours, theirs = program.solve(), program.solve(use_kernel=False)
    assert (ours >= program.lower - 1e-9).all()
    assert (ours <= program.upper + 1e-9).all()
    assert program.cost(ours) == pytest.approx(program.cost(theirs), abs=1e-4)
    rng = np.random.default_rng(seed)
    for other in rng.uniform(program.lower, program.upper, (20, num_variables)):
        assert program.cost(ours) <= program.cost(other) + 1e-4


@NATIVELY
@pytest.mark.parametrize(
    ("price", "x"),
    # A row that wants x >= 1 against a cost that wants less: kept if its price is higher.
    [(0.5, -2.0), (2.0, 1.0)],
)
def test_a_row_is_kept_if_its_price_is_high_enough(natively, price, x):
    row = PenaltyRows(np.array([[0, -1]]), np.array([[1.0, 7.0]]), np.array([1.0]), price)
    one = np.ones(1)
    program = PenaltyQp(one, 0 * one, -2 * one, 2 * one, (row,))
    assert program.solve(use_kernel=natively)[0] == pytest.approx(x, abs=1e-4)
    assert program.cost(np.array([x])) == pytest.approx(x + price * max(0.0, 1 - x))


@NATIVELY
def test_rows_that_contradict_one_another_share_the_damage(natively):
    rows = PenaltyRows(np.array([[0], [0]]), np.array([[1.0], [-1.0]]), np.array([1.0, 1.0]), 3.0)
    zero, one = np.zeros(1), np.ones(1)
    program = PenaltyQp(zero, one, -5 * one, 5 * one, (rows,))
    assert program.solve(use_kernel=natively)[0] == pytest.approx(0.0, abs=1e-4)
    assert program.cost(zero) == pytest.approx(6.0)


@given(seed=st.integers(0, 2**32 - 1))
def test_rows_between_bounds_keep_a_sum_within_them(seed):
    rng = np.random.default_rng(seed)
    values, now, x = rng.normal(size=(5, 2)), rng.normal(size=5), rng.normal(size=2)
    low, high = -rng.uniform(0.1, 2.0, 5), rng.uniform(0.1, 2.0, 5)
    rows = PenaltyRows.between(np.tile([0, 1], (5, 1)), values, now, np.stack([low, high]), 2.0)
    sums = now + values @ x
    # In units of the bound that is exceeded.
    excess = np.maximum(np.maximum(sums / high, sums / low) - 1, 0).sum()
    assert rows.penalty_at(x) == pytest.approx(2.0 * excess)


def random_products(seed: int, num_variables: int, num_rows: int) -> ProductRows:
    """Return rows in blocks of equal columns and weights; one weight of each may have no column."""
    rng = np.random.default_rng(seed)
    blocks = np.sort(rng.integers(0, 4, num_rows))
    columns = np.sort(rng.integers(0, (num_variables - 3) // 3, (4, 2)) * 3, axis=1)
    columns[:, 0][columns[:, 0] == columns[:, 1]] = -1
    return ProductRows(
        columns[blocks],
        rng.normal(size=(4, 2))[blocks],
        rng.normal(size=(num_rows, 3)),
        rng.normal(size=num_rows),
        0.7,
    )


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 2**32 - 1), num_rows=st.integers(0, 40))
def test_rows_of_products_are_those_with_all_their_entries(seed: int, num_rows: int) -> None:
    program = random_program(seed, 15, 20)
    products = random_products(seed, 15, num_rows)
    compact = replace(program, products=products)
    expanded = replace(program, rows=(*program.rows, products.expanded))
    x = np.random.default_rng(seed).uniform(program.lower, program.upper)
    for k, row in enumerate(products.columns):
        entries = [
            products.weights[k, i] * products.slopes[k, j] * x[column + j]
            for i, column in enumerate(row)
            for j in range(3)
            if column >= 0
        ]
        violation = products.lower_bounds[k] - sum(entries)
        assert products.expanded.violations(x)[k] == pytest.approx(violation)
    assert compact.cost(x) == expanded.cost(x)
    np.testing.assert_allclose(compact.solve(), expanded.solve(), atol=1e-6)


@pytest.mark.skipif(native() is None, reason="the native kernel is not built")
@settings(max_examples=num_cases(20))
@given(seed=st.integers(0, 2**32 - 1), num_rows=st.integers(1, 20), num_slopes=st.integers(3, 9))
def test_blocks_of_many_columns_take_the_same_steps(seed: int, num_rows: int, num_slopes: int):
    """As rows of products, of which the kernel never has the entries."""
    rng = np.random.default_rng(seed)
    first = np.sort(rng.choice(8, 4, replace=False)) * num_slopes
    weights, count = rng.normal(size=4), 8 * num_slopes + 1
    slopes, least = rng.normal(size=(num_rows, num_slopes)), rng.normal(size=num_rows)
    columns = (first[:, None] + np.arange(num_slopes)).ravel()
    # In any order, and one column apart from the others.
    order = rng.permutation(len(columns) + 1)
    entries = np.append(columns, count - 1)[order]
    values = np.concatenate(
        [(weights[:, None] * slopes[:, None]).reshape(num_rows, -1), np.zeros((num_rows, 1))], 1
    )[:, order]
    module: Any = native()
    variables = rng.normal(size=count), np.full(count, 0.1), np.full(count, -2.0), np.ones(count)
    price, no_rows = np.full(num_rows, 0.7), (np.zeros(1, np.int64), np.zeros(0, np.int64))
    dense = np.arange(num_rows + 1) * len(entries), np.tile(entries, num_rows), values.ravel()
    products = np.tile(first, (num_rows, 1)), np.tile(weights, (num_rows, 1)), slopes
    for steps in (1, 3, 6):
        answers = [
            module.solve_penalty_qp(variables, *given, _NO_BALLS, least, price, 0.0, steps)[0]
            for given in ((dense, _NO_PRODUCTS), ((*no_rows, np.zeros(0)), products))
        ]
        np.testing.assert_allclose(*answers, rtol=0, atol=1e-9)


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 2**32 - 1), num_rows=st.integers(1, 60))
def test_products_that_are_not_broken_can_be_left_out(seed: int, num_rows: int) -> None:
    rng = np.random.default_rng(seed)
    products = random_products(seed, 15, num_rows)
    largest_changes = np.abs(products.slopes).sum(axis=1)
    # Some rows hold with a little to spare, so that steps break them; some with much.
    margins = rng.uniform(-0.2, 1.2, num_rows) * largest_changes
    products = replace(products, lower_bounds=-margins)
    box = np.ones(15)
    program = replace(
        random_program(seed, 15, 30), products=products, lower=-box, upper=box, q=0.01 * box
    )
    whole, active = program.solve(), program.solve_by_active_rows()
    assert program.cost(active) == pytest.approx(program.cost(whole), rel=1e-5, abs=1e-5)


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 2**32 - 1), num_rows=st.integers(1, 60))
def test_loads_that_are_not_broken_can_be_left_out(seed: int, num_rows: int) -> None:
    rng = np.random.default_rng(seed)
    # Of which the minimizer without them breaks some that were not likely to be.
    rows = random_program(seed + 1, 15, num_rows).rows
    margins = [rng.uniform(-0.2, 1.5, len(part.lower_bounds)) for part in rows]
    loads = tuple(replace(part, lower_bounds=-m) for part, m in zip(rows, margins, strict=True))
    box = np.ones(15)
    program = random_program(seed, 15, 30)
    program = replace(program, loads=loads, lower=-box, upper=box, q=0.01 * box)
    whole, active = program.solve(), program.solve_by_active_rows()
    assert program.cost(active) == pytest.approx(program.cost(whole), rel=1e-5, abs=1e-5)


def resized(program: PenaltyQp, sizes: np.ndarray) -> PenaltyQp:
    """Return the program with rows in other units, at the same price for the same violation."""
    rows = [part.selected([k]) for part in program.rows for k in range(len(part.lower_bounds))]
    return replace(
        program,
        rows=tuple(
            PenaltyRows(row.columns, row.values * size, row.lower_bounds * size, row.penalty / size)
            for row, size in zip(rows, sizes, strict=True)
        ),
    )


@settings(max_examples=num_cases(8))
@given(seed=st.integers(0, 2**32 - 1), decades=st.integers(1, 60))
def test_the_size_of_a_row_does_not_matter(seed: int, decades: int) -> None:
    # Jerks, torques and distances differ by many powers of ten.
    program = random_program(seed, 12, 36)
    sizes = 10.0 ** np.random.default_rng(seed).uniform(-decades / 2, decades / 2, 40)
    x, in_other_units = program.solve(), resized(program, sizes).solve()
    assert (in_other_units >= program.lower - 1e-9).all()
    assert (in_other_units <= program.upper + 1e-9).all()
    assert program.cost(in_other_units) == pytest.approx(program.cost(x), abs=1e-4)


@settings(max_examples=num_cases(8))
@given(seed=st.integers(0, 2**32 - 1), decades=st.integers(1, 10))
def test_large_rows_beside_small_ones_are_solved(seed: int, decades: int) -> None:
    program = random_program(seed, 12, 36)
    size = 10.0 ** np.random.default_rng(seed).uniform(0, decades, (36, 1))
    wild = replace(program.rows[0], values=program.rows[0].values * size)
    program = replace(program, rows=(wild, program.rows[1]))
    cost, reference = (program.cost(program.solve(use_kernel=k)) for k in (True, False))
    assert cost <= reference + 1e-3 * max(1.0, abs(reference))


def random_balls(seed: int, num_variables: int, num_balls: int) -> BallRows:
    """Return balls of some columns each, many of them left by the minimizer without them."""
    rng = np.random.default_rng(seed)
    blocks = np.sort(rng.integers(0, 4, num_balls))
    columns = np.stack([rng.choice(num_variables, 5, replace=False) for _ in range(4)])
    columns[rng.uniform(size=columns.shape) < 0.1] = -1
    directions = rng.normal(size=(num_balls, 3))
    lengths = rng.uniform(0.0, 1.2, (num_balls, 1))
    centers = lengths * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return BallRows(columns[blocks], rng.normal(size=(num_balls, 3, 5)), centers, 0.7)


@settings(max_examples=num_cases(8))
@given(seed=st.integers(0, 2**32 - 1), num_balls=st.integers(1, 40))
def test_vectors_in_balls_cost_the_least_too(seed: int, num_balls: int) -> None:
    balls = random_balls(seed, 15, num_balls)
    program = replace(random_program(seed, 15, 20), balls=(balls,))
    ours, theirs = program.solve(), program.solve(use_kernel=False)
    assert (ours >= program.lower - 1e-9).all()
    assert (ours <= program.upper + 1e-9).all()
    assert program.cost(ours) == pytest.approx(program.cost(theirs), abs=1e-5)
    rng = np.random.default_rng(seed)
    for other in rng.uniform(program.lower, program.upper, (20, 15)):
        assert program.cost(ours) <= program.cost(other) + 1e-5


@NATIVELY
def test_a_vector_goes_as_far_as_its_ball(natively):
    """The point of a disc that is the farthest along a direction, as one finds it by hand."""
    direction = np.array([0.6, -0.8, 0.0])
    values = np.eye(3)[None]
    ball = BallRows(np.arange(3)[None], values, np.array([[0.2, 0.1, 0.0]]), 10.0)
    far = PenaltyRows(np.array([[0]]), np.ones((1, 1)), np.array([-9.0]), 1.0)
    three = np.full(3, 3.0)
    program = PenaltyQp(-direction, 0 * three, -three, three, (far,), balls=(ball,))
    x = program.solve(use_kernel=natively)
    np.testing.assert_allclose(x, direction - [0.2, 0.1, 0.0], atol=1e-3)
    assert np.abs(ball.violations(x)).max() < 1e-5


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 2**32 - 1), num_balls=st.integers(1, 60))
def test_balls_that_are_not_left_can_be_left_out(seed: int, num_balls: int) -> None:
    box = np.ones(15)
    program = replace(
        random_program(seed, 15, 30),
        balls=(random_balls(seed, 15, num_balls),),
        lower=-box,
        upper=box,
        q=0.01 * box,
    )
    whole, active = program.solve(), program.solve_by_active_rows()
    assert program.cost(active) == pytest.approx(program.cost(whole), rel=1e-5, abs=1e-5)
