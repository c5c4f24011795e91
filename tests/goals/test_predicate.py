"""Predicate goals: configurations that a function accepts."""

import pickle

import numpy as np
import pytest

import planning
from planning.domain.goals.goal import ConfigurationGoal, GoalPredicate
from planning.domain.request.options import IkOptions, RefineOptions
from planning.domain.request.problem import PlanningProblem
from planning.errors import GoalInCollision, GoalUnreachable, ProblemInvalid
from tests.clocks import no_hurry
from tests.goals.conftest import ask, world_by


def is_left(q: np.ndarray) -> bool:
    return bool(q[0] > 1.0)


def test_what_is_found_is_accepted_free_and_nearest_first() -> None:
    world = world_by("ur5e_pickup", "kernel")
    group = world.group("arm")
    found = ask(world, "arm", GoalPredicate(is_left), IkOptions(10, 400))
    assert len(found.positions) == 10
    for q in found.positions:
        assert is_left(q)
        assert not world.violations(group, q, world.margins())
    distances = np.linalg.norm(found.positions - world.positions(group), axis=1)
    assert (np.diff(distances) >= 0).all()
    assert found == ask(world, "arm", GoalPredicate(is_left), IkOptions(10, 400))


def test_it_can_be_planned_to() -> None:
    world = world_by("ur5e_pickup", "kernel")
    problem = PlanningProblem(
        "arm", GoalPredicate(is_left), ik=IkOptions(2, 60), refine=RefineOptions("none")
    )
    found = planning.plan(problem, world, deadline=no_hurry(20.0))
    assert found.certificate.proven
    assert is_left(found.goal_configuration)


def test_candidates_may_be_drawn_by_its_owner() -> None:
    world = world_by("ur5e_pickup", "kernel")
    home = world.positions(world.group("arm"))

    def near_home(rng: np.random.Generator) -> np.ndarray:
        return home + rng.uniform(-0.02, 0.02, 6)

    found = ask(world, "arm", GoalPredicate(lambda q: q[0] > home[0], near_home), IkOptions(5, 100))
    assert (np.abs(found.positions - home) <= 0.02).all()
    with pytest.raises(ProblemInvalid, match=r"goal\.draw"):
        ask(world, "arm", GoalPredicate(is_left, lambda _: np.zeros(5)))


def test_refusals_say_what_was_tried() -> None:
    world = world_by("ur5e_pickup", "kernel")
    with pytest.raises(GoalUnreachable, match="accepts none of 50") as refusal:
        ask(world, "arm", GoalPredicate(lambda _: False), IkOptions(5, 50))
    assert refusal.value.evidence["funnel"]["rejected"] == [
        {
            "reason": "not_converged",
            "count": 50,
            "share": 1.0,
            "bodies": None,
            "min_depth": None,
            "max_depth": None,
        }
    ]
    stuck = GoalPredicate(lambda _: True, lambda _: np.zeros(6))
    with pytest.raises(GoalInCollision) as refusal:
        ask(world, "arm", stuck, IkOptions(5, 20))
    assert refusal.value.evidence["relaxation"]["obstacles"]


def test_other_goals_hash_and_pickle_as_ever() -> None:
    problem = PlanningProblem("arm", ConfigurationGoal("home"))
    assert hash(pickle.loads(pickle.dumps(problem))) == hash(problem)
    goal = GoalPredicate(is_left)
    assert goal == goal  # noqa: PLR0124
    assert goal != GoalPredicate(is_left)
    with pytest.raises(TypeError, match="no digest"):
        hash(PlanningProblem("arm", goal))
