"""Every option of a plan reaches planning: a field that `to_domain()` forgets is found here."""

import pytest

from service.plans.models.ik import Ik
from service.plans.models.refine import Refine, RefineObjective
from service.plans.models.request import Certify, PlanRequest, Retime
from service.plans.models.search import Search

# For each field a value that is not its default; and what the field needs besides, if anything.
VALUES = {
    Search: {
        "planner": ["PRM", "RRT"],
        "parameters": {"range": 0.5},
        "attempts": 2,
        "allowed_planning_time": 1.0,
        "resolution": 0.01,
        "num_states": 9,
        "weights": {"a::j": 2.0},
        "bounds": {"a::j": [-1.0, 1.0]},
        "spaces": {"a::j": "position"},
        "setup_time": 1.0,
        "solve_time": 1.0,
        "shortcut_time": 1.0,
        "interpolate_time": 1.0,
        "objective": "clearance",
        "approximate": True,
        "keep_graph": True,
        "on_cancel": "best",
        "approach_states": 9,
        "roadmap": {},
    },
    Ik: {
        "max_configurations": 3,
        "max_trials": 4,
        "joint_weights": {"a::j": 2.0},
        "pose_metric": {"rotation": 0.5},
        "allowed_time": 1.0,
    },
    Refine: {
        "method": "auto",
        "clearance": {"distance": 0.05, "weight": 2.0},
        "objective": {"duration": 2.0},
    },
    RefineObjective: {
        "duration": 2.0,
        "smoothness": 2.0,
        "energy": 2.0,
        "path_length": 2.0,
        "derivative": "jerk",
        "max_duration": 2.0,
    },
    Retime: {
        "method": "ruckig",
        "velocity_scale": 0.5,
        "acceleration_scale": 0.5,
        "sample_period": 0.5,
        "duration": 9.0,
        "deviation": 0.01,
        "explain": True,
        "effort": True,
        "payload": {"frame": "a::t", "mass": 1.0},
        "tool_limits": [{"frame": "a::t", "speed": 0.25}],
        "speed_zones": [
            {"name": "slow", "frame": "a::t", "box": {"size": [1, 1, 1]}, "speed": 0.1}
        ],
        "acceleration_bounds": {"a::j": [-1.0, 1.0]},
    },
    Certify: {"stop_anywhere": True, "max_stopping_time": 9.0, "robustness": True},
}
# What the service uses itself, before or after planning.
OF_THE_SERVICE = {Search: {"regions"}, Retime: {"num_points", "even_samples"}}


@pytest.mark.parametrize("model", VALUES, ids=lambda model: model.__name__)
def test_every_field_has_a_value_here(model):
    assert set(VALUES[model]) == set(model.model_fields) - OF_THE_SERVICE.get(model, set())


@pytest.mark.parametrize(
    ("model", "field"), [(model, field) for model, values in VALUES.items() for field in values]
)
def test_every_option_arrives(model, field):
    plain = model().to_domain()
    assert model.model_validate({field: VALUES[model][field]}).to_domain() != plain


def test_every_part_of_a_request_arrives():
    goal = {"type": "configuration", "name": "home"}
    base = {"scene": "s", "group": "a", "goal": goal}
    plain = PlanRequest.model_validate(base).to_domain()
    parts = {
        "ik": {"max_trials": 4},
        "search": {"attempts": 2},
        "refine": {"method": "none"},
        "retime": {"method": "ruckig"},
        "certify": {"robustness": True},
        "group": "b",
        "start": [1.0],
        "goal": {"type": "configuration", "name": "away"},
        "path_constraints": [{"type": "locked_joints", "joints": ["a::j"]}],
        "margin": 0.5,
        "seed": 7,
    }
    assert set(parts) == set(PlanRequest.model_fields) - {"scene", "revision", "priority"}
    for name, said in parts.items():
        assert PlanRequest.model_validate({**base, name: said}).to_domain() != plain, name
