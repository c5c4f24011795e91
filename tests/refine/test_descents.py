"""Descents end early where they lead to nothing better, and the best of several is kept."""

from collections.abc import Callable

import numpy as np
import pytest

from planning.refine.descents.descent import MAX_STEPS, Descent
from planning.refine.descents.multi_start import solve_multi_start
from planning.refine.descents.two_descents import two_descents
from planning.refine.refine_problem import RefineProblem
from planning.world.world import World
from tests.clocks import no_hurry
from tests.refine.conftest import Case, case_of


@pytest.fixture
def detour(make_puck: Callable[..., World]) -> Case:
    """A path that must go about a bar: no curve is as quick as a straight line."""
    world = make_puck([([0.1, 1.0, 0.2], [0.0, -0.2, 0.0])])
    waypoints = [[-0.5, -0.3], [-0.2, 0.5], [0.2, 0.6], [0.5, -0.3]]
    return case_of(world, "puck", np.array(waypoints))


def problem_of(case: Case) -> RefineProblem:
    return RefineProblem.of(case.world, case.request, no_hurry())


def begun(problem: RefineProblem) -> Descent:
    return problem.descent(problem.fit_path(0.15))


def objective_of(descent: Descent) -> float:
    assert descent.best is not None, descent.reason
    return descent.best.objective


def test_a_descent_that_leads_to_nothing_better_ends(detour: Case) -> None:
    problem = problem_of(detour)
    whole, hopeless, hopeful = begun(problem), begun(problem), begun(problem)
    whole.advance()
    # Nothing is as quick as half the lower bound.
    hopeless.advance(to_beat=problem.lower_bound / 2)
    assert hopeless.num_steps < whole.num_steps
    assert objective_of(hopeless) > objective_of(whole)
    hopeful.advance(to_beat=2 * objective_of(whole))
    assert hopeful.num_steps == whole.num_steps


def test_the_best_of_two_descents_is_kept(detour: Case) -> None:
    problem = problem_of(detour)
    first = begun(problem)
    first.advance()
    assert objective_of(first) > 1.03 * problem.lower_bound
    result = solve_multi_start(detour.world, problem)
    assert result.best is not None
    assert result.best.objective <= objective_of(first)
    assert first.num_steps < result.num_steps <= first.num_steps + MAX_STEPS


def test_a_descent_that_pauses_goes_on_as_if_it_had_not(detour: Case) -> None:
    problem = problem_of(detour)
    whole, paused = begun(problem), begun(problem)
    whole.advance()
    for num_steps in (3, 7):
        paused.advance(max_steps=num_steps)
        assert not paused.is_finished
        assert num_steps <= paused.num_steps < whole.num_steps
    paused.advance()
    assert paused.is_finished
    assert paused.num_steps == whole.num_steps
    assert paused.points.tobytes() == whole.points.tobytes()


def test_a_descent_that_is_far_behind_ends_sooner_the_less_is_foreseen(detour: Case) -> None:
    problem = problem_of(detour)
    whole, foreseen, unforeseen = begun(problem), begun(problem), begun(problem)
    whole.advance()
    to_beat = 0.9 * objective_of(whole)
    foreseen.advance(to_beat)
    unforeseen.advance(to_beat, num_foreseen=0)
    assert unforeseen.num_steps < foreseen.num_steps <= whole.num_steps


def test_the_second_descent_leaves_the_longer_side_of_an_obstacle(
    make_puck: Callable[..., World],
) -> None:
    # The straight line passes through the upper part of a block, the path far below it.
    world = make_puck([([0.4, 0.4, 0.2], [0.0, -0.17, 0.0])])
    waypoints = [[-0.5, 0.0], [-0.4, -0.6], [0.4, -0.6], [0.5, 0.0]]
    problem = problem_of(case_of(world, "puck", np.array(waypoints)))
    alone = begun(problem)
    alone.advance()
    assert alone.points[:, 1].min() < -0.35
    first, second = two_descents(problem, problem.fit_path(0.15))
    assert second.points[:, 1].min() > -0.05
    assert objective_of(second) < 0.95 * objective_of(alone)
    assert first.num_steps <= alone.num_steps


def test_there_is_no_second_descent_where_the_first_is_good(
    make_puck: Callable[..., World],
) -> None:
    waypoints = [[-0.5, -0.3], [0.0, -0.25], [0.5, -0.3]]
    problem = problem_of(case_of(make_puck([]), "puck", np.array(waypoints)))
    (only,) = two_descents(problem, problem.fit_path(0.15))
    assert objective_of(only) < 1.03 * problem.lower_bound
