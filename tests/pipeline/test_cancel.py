"""Canceled plans return nothing, or the best motion so far, certified."""

import numpy as np
import pytest

import planning
from planning.domain.goals.goal import JointGoal
from planning.domain.report.motion_plan import Progress
from planning.domain.request.options import RefineOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.errors import Canceled
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.pipeline.test_plan import GROUPS, to_frame
from tests.profiles import seeds

# A wall thinner than the search looks: its shortest paths cut the end of it.
THIN = {
    "robots": [{"name": "body", "model": "planar_l", "positions": [-0.35, -0.3, 0]}],
    "objects": [
        {"name": "wall", "shape": {"box": [0.02, 0.5, 0.2]}, "pose": {"position": [0, -0.25, 0]}}
    ],
}


@pytest.mark.parametrize("scene", ["maze_2d", "panda_shelf"])
def test_a_cancel_leaves_a_proven_plan_to_who_wants_the_best_so_far(scene: str) -> None:
    world = bundled_world(scene)
    seen: list[float] = []

    def note(progress: Progress) -> None:
        seen.extend([] if progress.best_length is None else [progress.best_length])

    goal = to_frame("exit" if scene == "maze_2d" else "lower")
    options = {"attempts": 50, "allowed_planning_time": 30.0}
    for on_cancel in ("best", "discard"):
        seen.clear()
        deadline = no_hurry(30.0, lambda: bool(seen))
        search = SearchOptions(**options, on_cancel=on_cancel)
        problem = PlanningProblem(GROUPS[scene], goal, search=search)
        if on_cancel == "discard":
            with pytest.raises(Canceled):
                planning.plan(problem, world, deadline=deadline, on_progress=note)
            continue
        found = planning.plan(problem, world, deadline=deadline, on_progress=note)
        assert found.certificate.proven
        assert found.stages.search.was_canceled
        assert found.stages.search.solved == 1
        assert not found.stages.refine.improved


@pytest.mark.campaign
@pytest.mark.parametrize("seed", seeds(3, 240))
@pytest.mark.parametrize("after", [1, 2, 3])
def test_a_best_so_far_that_cannot_be_proven_is_searched_for_once_more(
    seed: int, after: int
) -> None:
    world = planning.load_world(planning.parse_scene(THIN))
    seen: list[float] = []

    def note(progress: Progress) -> None:
        seen.extend([] if progress.best_length is None else [progress.best_length])

    deadline = no_hurry(30.0, lambda: len(seen) >= after)
    search = SearchOptions(attempts=100, on_cancel="best", allowed_planning_time=20.0)
    goal = JointGoal(np.array([[0.3, -0.3, 0.0]]))
    problem = PlanningProblem("body", goal, search=search, refine=RefineOptions("none"), seed=seed)
    found = planning.plan(problem, world, deadline=deadline, on_progress=note)
    assert found.certificate.proven
    # A few seeds improve less often than that in all of their attempts.
    assert found.stages.search.was_canceled == (len(seen) >= after)


@pytest.mark.parametrize("goal", [(-0.21, -0.36, 0.29), (-0.2, 0.04, 0.34)])
def test_the_only_path_that_a_planner_was_improving_is_proven(goal: tuple[float, ...]) -> None:
    world = bundled_world("maze_2d")
    seen: list[float] = []

    def note(progress: Progress) -> None:
        seen.extend([] if progress.best_length is None else [progress.best_length])

    deadline = no_hurry(20.0, lambda: bool(seen))
    search = SearchOptions("RRTstar", on_cancel="best", allowed_planning_time=20.0)
    problem = PlanningProblem("body", JointGoal(np.array([goal])), search=search)
    found = planning.plan(problem, world, deadline=deadline, on_progress=note)
    assert found.certificate.proven
    assert found.stages.search.was_canceled
    assert found.stages.search.planner == "RRTstar"
