"""Requests become problems with nothing lost."""

import numpy as np
import pytest
from pydantic import ValidationError

from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import (
    ConfigurationGoal,
    JointGoal,
    PoseGoal,
    RegionGoal,
    RelativeGoal,
)
from planning.domain.request.options import ClearanceObjective, IkOptions, PoseMetric, RefineOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.request.refine_objective import RefineObjective
from service.plans.models.request import PlanRequest

BASE = {"scene": "s", "group": "arm"}


def problem(**fields):
    return PlanRequest.model_validate({**BASE, **fields}).to_domain()


def test_defaults_of_requests_are_those_of_the_domain():
    goal = {"type": "configuration", "name": "home"}
    assert problem(goal=goal) == PlanningProblem("arm", ConfigurationGoal("home"))


def test_every_option_arrives():
    made = problem(
        goal={"type": "joint", "positions": [1, 2]},
        start=[0.5, 1],
        ik={"max_configurations": 3, "max_trials": 4},
        search={
            "planner": "PRM",
            "parameters": {"max_nearest_neighbors": 4, "x": 0.5, "y": True, "z": "s"},
            "attempts": 2,
            "allowed_planning_time": 1,
            "resolution": 0.01,
            "num_states": 9,
        },
        refine={"method": "auto", "clearance": {"distance": 0.05, "weight": 2}},
        retime={
            "method": "ruckig",
            "velocity_scale": 0.5,
            "acceleration_scale": 0.25,
            "sample_period": 0.02,
        },
        margin=0.02,
        seed=7,
    )
    assert (made.ik.max_configurations, made.ik.max_trials) == (3, 4)
    search = made.search
    assert dict(search.parameters) == {"max_nearest_neighbors": 4, "x": 0.5, "y": True, "z": "s"}
    assert [type(item) for item in search.parameters.values()] == [int, float, bool, str]
    assert (search.planner, search.attempts, search.num_states) == ("PRM", 2, 9)
    assert (search.allowed_planning_time, search.resolution) == (1.0, 0.01)
    assert made.refine == RefineOptions("auto", ClearanceObjective(0.05, 2.0))
    assert (made.retime.method, made.retime.sample_period) == ("ruckig", 0.02)
    assert (made.retime.velocity_scale, made.retime.acceleration_scale) == (0.5, 0.25)
    assert (made.margin, made.seed) == (0.02, 7)
    np.testing.assert_array_equal(made.start, [0.5, 1.0])


def test_a_clearance_objective_without_refinement_is_refused():
    with pytest.raises(ValidationError, match="requires method 'trajopt' or 'auto'"):
        problem(
            goal={"type": "joint", "positions": [1, 2]},
            refine={"method": "none", "clearance": {"distance": 0.05, "weight": 2}},
        )


def test_one_or_several_joint_goals():
    for positions, rows in (([1, 2], [[1, 2]]), ([[1, 2], [3, 4]], [[1, 2], [3, 4]])):
        made = problem(goal={"type": "joint", "positions": positions})
        assert made.goal == JointGoal(np.array(rows, dtype=np.float64))


def test_poses_keep_their_frames_and_tolerances():
    made = problem(
        goal={
            "type": "pose",
            "frame": "arm::tool0",
            "poses": [{"position": [1, 2, 3], "frame": "can"}, {"position": [0, 0, 0]}],
            "tolerance": {"position": [0.1, 0, 0], "rotation": [0, 0, 4]},
        }
    ).goal
    assert isinstance(made, PoseGoal)
    assert [target.frame for target in made.targets] == ["can", "world"]
    assert made.frame == "arm::tool0"
    np.testing.assert_array_equal(made.targets[0].pose.position, [1, 2, 3])
    np.testing.assert_array_equal(made.position_tolerance, [0.1, 0, 0])
    np.testing.assert_array_equal(made.rotation_tolerance, [0, 0, 4])


def test_regions_are_free_where_they_say_so():
    made = problem(
        goal={
            "type": "region",
            "pose": {"position": [1, 2, 3], "frame": "can"},
            "tolerance": {"position": [0.1, 0.2, 0.3], "rotation": [0.4, 0.5, 0.6]},
            "free_axes": ["y", "rz"],
        }
    ).goal
    assert isinstance(made, RegionGoal)
    assert [target.frame for target in made.targets] == ["can"]
    np.testing.assert_array_equal(made.position_tolerance, [0.1, np.inf, 0.3])
    np.testing.assert_array_equal(made.rotation_tolerance, [0.4, 0.5, np.pi])


def test_displacements_may_be_only_a_turn():
    made = problem(
        goal={"type": "relative", "displacement": {"rpy": [0, 0, 1]}, "reference": "can"}
    ).goal
    assert made == RelativeGoal(Pose.from_parts(rpy=[0, 0, 1]), "", "can")


def test_weights_and_metric_arrive():
    ik = {"joint_weights": {"arm::a": 2}, "pose_metric": {"translation": 3, "rotation": 0.5}}
    made = problem(goal={"type": "configuration", "name": "home"}, ik=ik).ik
    assert made == IkOptions(joint_weights={"arm::a": 2.0}, pose_metric=PoseMetric(3.0, 0.5))


def test_an_objective_arrives_with_all_its_weights():
    objective = {
        "duration": 1,
        "smoothness": 2,
        "energy": 0.5,
        "path_length": 3,
        "derivative": "jerk",
        "max_duration": 4,
    }
    goal = {"type": "configuration", "name": "home"}
    made = problem(goal=goal, refine={"method": "drake", "objective": objective})
    assert made.refine == RefineOptions(
        "drake", None, RefineObjective(1.0, 2.0, 0.5, 3.0, "jerk", 4.0)
    )


@pytest.mark.parametrize(
    ("refine", "reason"),
    [
        ({"objective": {"energy": 1}}, "give max_duration"),
        ({"method": "none", "objective": {"duration": 1}}, "optimizes nothing"),
        ({"method": "drake", "objective": {"smoothness": 1}}, "give max_duration"),
        ({"method": "drake", "objective": {}}, "must be positive"),
        ({"method": "drake", "objective": {"duration": -1}}, "greater than or equal to 0"),
        ({"method": "drake", "clearance": {"distance": 0.1, "weight": 1}}, "not 'drake'"),
        (
            {"objective": {"duration": 1}, "clearance": {"distance": 0.1, "weight": 1}},
            "exclude each other",
        ),
    ],
)
def test_an_objective_that_a_method_does_not_know_is_refused(refine, reason):
    goal = {"type": "configuration", "name": "home"}
    with pytest.raises(ValidationError, match=reason):
        problem(goal=goal, refine=refine)
