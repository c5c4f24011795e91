"""Calls about motions: those of plans, one's own, regions, and executions."""

from typing import Any

from tests.golden.service.calls import Call, From, get, post
from tests.golden.service.plan_calls import plan

_CHARTS = ("velocity", "utilisation")
_TRAJECTORY = "/v1/plans/{configuration}/trajectory"
_OF_PLANS = (
    get("trajectory", _TRAJECTORY),
    get("trajectory_by_period", f"{_TRAJECTORY}?period=0.2&even=true"),
    get("trajectory_by_points", f"{_TRAJECTORY}?points=7&scale=0.5"),
    get("trajectory_exactly", f"{_TRAJECTORY}?polynomial=true&points=3"),
    get("trajectory_as_csv", f"{_TRAJECTORY}?format=csv&period=0.2"),
    get("trajectory_of_a_reversal", "/v1/plans/{reverse}/trajectory?points=3"),
    get("replay", "/v1/plans/{configuration}/replay.html"),
    *(get(f"plot_{name}", f"/v1/plans/{{configuration}}/plots/{name}.svg") for name in _CHARTS),
    get("series", "/v1/plans/{configuration}/series?points=3"),
    get("plot_clearance", "/v1/plans/{joint}/plots/clearance.svg"),
    get("plot_tool_speed", "/v1/plans/{limited}/plots/tool_speed.svg"),
)


def _own(name: str, what: str, **body: Any) -> Call:
    whole = {"scene": From("square"), "group": "body", "allowed_time": 60.0, **body}
    return post(name, f"/v1/trajectories/{what}", whole)


def _arm(name: str, what: str, **body: Any) -> Call:
    return _own(name, what, **{**body, "scene": From("arm"), "group": "arm"})


_RUNNING = From("trajectory_exactly", "")
_SLOW = {"times": [0, 4], "positions": [[0.3, -0.35, 0], [0.1, -0.35, 0.3]]}
_ELSEWHERE = {"times": [0, 4], "positions": [[0.3, -0.36, 0], [0.1, -0.35, 0.3]]}
_THROUGH = {"times": [0, 9], "positions": [[0.3, -0.35, 0], [0.3, 0.3, 0]]}
_HOME = [0, -1.57, 1.57, -1.57, -1.57, 0]
_REST = {"velocities": [[0] * 6] * 2, "accelerations": [[0] * 6] * 2}
_REACH = {"times": [0, 4], "positions": [_HOME, [0.3, -1.5, 1.5, -1.57, -1.57, 0]], **_REST}
_RAISE = {"times": [0, 4], "positions": [_HOME, [0.3, -1.6, 1.5, -1.57, -1.57, 0]], **_REST}
_FEW = {"num_points": 5}
_OWN = (
    _own("retime", "retime", waypoints=From("configuration", "/result/path"), retime=_FEW),
    _own(
        "retime_through_the_wall", "retime", waypoints=[[0.3, -0.35, 0], [0.3, 0.3, 0]], retime=_FEW
    ),
    _own("certify", "certify", trajectory=_RUNNING),
    _own("certify_samples", "certify", trajectory=_SLOW, limit_jerk=False),
    _own("certify_through_the_wall", "certify", trajectory=_THROUGH),
    _own("stop", "stop", trajectory=_SLOW, time=1.5, **_FEW),
    _own("stop_along_the_path", "stop", trajectory=_SLOW, time=1.5, along_path=True, **_FEW),
    _arm("stop_of_an_arm", "stop", trajectory=_REACH, time=1.5, **_FEW),
    _arm("splice_of_an_arm", "splice", trajectory=_REACH, time=1.0, onto=_RAISE, **_FEW),
    _own("splice", "splice", trajectory=_SLOW, time=1.0, onto=_ELSEWHERE, **_FEW),
)
_GROW = {
    "group": "body",
    "num_regions": 8,
    "num_free": 200,
    "iterations": 1,
    "seed": 2,
    "allowed_time": 3600.0,
}
_SOON = {"planner": "GCS"}
_REGIONS = (
    plan("no_regions_yet", {"type": "configuration", "name": "beyond"}, search=_SOON),
    post("regions", "/v1/scenes/{square}/regions?wait=60", _GROW),
    get("regions_again", "/v1/regions/{regions}"),
    get("regions_events", "/v1/regions/{regions}/events"),
    get("regions_of_a_scene", "/v1/scenes/{square}/regions"),
    post("regions_cancel", "/v1/regions/{regions}/cancel"),
    plan("through_regions", {"type": "configuration", "name": "beyond"}, search=_SOON),
)


def _execute(name: str, of: str, wait: str = "?wait=60", **rest: Any) -> Call:
    body = {"plan": From(of), "speed": 50.0, **rest.pop("body", {})}
    return post(name, f"/v1/executions{wait}", body, **rest)


_SLOW_ONE = "/v1/executions/{slow_execution}"
_CANCELED = "/v1/executions/{canceled_execution}"
_EXECUTIONS = (
    get("nothing_to_replay", "/v1/scenes/{square}/replay.html"),
    _execute("execution", "joint", body={"title": "go aside"}),
    get("execution_again", "/v1/executions/{execution}"),
    get("execution_events", "/v1/executions/{execution}/events"),
    get("moved_scene", "/v1/scenes/{square}"),
    get("moved_state", "/v1/scenes/{square}/state"),
    get("state_events", "/v1/scenes/{square}/state/events?most=1"),
    _execute("start_mismatch", "configuration"),
    post("late_cancel", "/v1/executions/{execution}/cancel"),
    post("late_pause", "/v1/executions/{execution}/pause"),
    _execute("slow_execution", "car", "", body={"speed": 0.05}, is_moving=True),
    get("moving", _SLOW_ONE, until=("state", "executing"), is_moving=True),
    _execute("robot_busy", "car"),
    post("pause", f"{_SLOW_ONE}/pause", is_moving=True),
    post("resume", f"{_SLOW_ONE}/resume", is_moving=True),
    post("speed", f"{_SLOW_ONE}/speed", {"speed": 50.0}, is_moving=True),
    get("slow_execution_events", f"{_SLOW_ONE}/events"),
    get("slow_execution_again", _SLOW_ONE),
    _execute("canceled_execution", "arm_plan", "", body={"speed": 0.01}, is_moving=True),
    get("moving_arm", _CANCELED, until=("state", "executing"), is_moving=True),
    post("cancel_execution", f"{_CANCELED}/cancel", is_moving=True),
    get("canceled_execution_again", _CANCELED, until=("state", "canceled")),
    _execute("not_executable", "goal_in_collision"),
    get("executions", "/v1/executions?limit=2"),
    get("executions_of_a_scene", "/v1/executions?scene={square}"),
    get("scene_replay", "/v1/scenes/{square}/replay.html?last=1"),
)
_TWO = {
    "name": "two",
    "robots": [
        {"name": "a", "model": "planar_l", "positions": [-0.3, 0.0, 0.0]},
        {"name": "b", "model": "planar_l", "positions": [0.0, -0.3, 0.0]},
    ],
    "groups": {"both": ["a", "b"]},
}
_ACROSS = {"type": "joint", "positions": [0.3, 0.0, 0.0]}
_UP = {"type": "joint", "positions": [0.0, 0.3, 0.0]}
_BOTH = {"type": "joint", "positions": [0.3, 0.0, 0.0, 0.0, 0.3, 0.0]}


def _schedule(name: str, *plans: str) -> Call:
    body = {"scene": From("two"), "plans": [From(plan) for plan in plans], "allowed_time": 60.0}
    return post(name, "/v1/trajectories/schedule", body)


SEVERAL_CALLS = (
    post("two", "/v1/scenes", _TWO),
    plan("plan_of_one", _ACROSS, "two", "a"),
    plan("plan_of_the_other", _UP, "two", "b"),
    # Refined, it would end elsewhere on another kind of machine.
    plan("plan_of_both", _BOTH, "two", ["a", "b"], refine={"method": "none"}),
    _schedule("schedule", "plan_of_one", "plan_of_the_other"),
    _schedule("schedule_of_one_robot_twice", "plan_of_one", "plan_of_one"),
)
MOTION_CALLS = (*_OF_PLANS, *_OWN, *_REGIONS, *_EXECUTIONS)
LAST_CALLS = (
    get("readiness", "/readyz"),
    get("metrics", "/metrics"),
    get("root", "/"),
    get("docs", "/docs"),
)
