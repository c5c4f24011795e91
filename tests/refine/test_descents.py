"""Descents can be paused and resumed, and end early only where they lead to nothing better."""

from collections.abc import Callable

import numpy as np
import pytest

from planning.refine.descents import multi_start
from planning.refine.descents.descent import MAX_STEPS, Descent
from planning.refine.descents.multi_start import solve_multi_start
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


def test_a_descent_with_pauses_is_that_without(detour: Case) -> None:
    problem = problem_of(detour)
    whole, paused = begun(problem), begun(problem)
    whole.advance()
    counts, objectives = [], []
    for num_steps in (1, 2, 7, 7, 12, MAX_STEPS):
        paused.advance(num_steps)
        counts.append(paused.num_steps)
        objectives.append(objective_of(paused))
    assert whole.num_steps > 7
    assert sorted(counts) == counts
    assert counts[3] == counts[2]
    assert sorted(objectives, reverse=True) == objectives
    assert counts[-1] == whole.num_steps
    assert whole.best is not None
    assert paused.best is not None
    np.testing.assert_array_equal(paused.best.points, whole.best.points)


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


def test_the_better_of_two_descents_is_finished(
    detour: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = problem_of(detour)
    begun_ones, advance = list[Descent](), Descent.advance
    objectives: dict[tuple[int, int], float] = {}

    def recorded(self: Descent, num_steps: int = MAX_STEPS, to_beat: float = np.inf) -> None:
        begun_ones.append(self)
        advance(self, num_steps, to_beat)
        objectives[id(self), num_steps] = np.inf if self.best is None else self.best.objective

    monkeypatch.setattr(Descent, "advance", recorded)
    result = solve_multi_start(detour.world, problem)
    first, second, finished = begun_ones
    assert first is not second
    paused = {
        first: objectives[id(first), multi_start.NUM_FIRST_STEPS],
        second: objectives[id(second), multi_start.NUM_SECOND_STEPS],
    }
    assert paused[first] > 1.03 * problem.lower_bound
    assert finished is min(paused, key=lambda descent: paused[descent])
    assert result.best is finished.best
    assert result.num_steps == first.num_steps + second.num_steps
    # Without the comparison both are finished.
    monkeypatch.undo()
    monkeypatch.setattr(multi_start, "NUM_FIRST_STEPS", MAX_STEPS)
    monkeypatch.setattr(multi_start, "NUM_SECOND_STEPS", MAX_STEPS)
    both = solve_multi_start(detour.world, problem)
    assert result.best is not None
    assert both.best is not None
    assert both.best.objective == pytest.approx(result.best.objective, rel=0.01)
