"""Calls that plan: each type of goal, options of each stage, failures by their codes."""

from typing import Any

from tests.golden.service.calls import Call, From, get, post

_PATIENT = {"allowed_planning_time": 60.0}
_COARSE = {"sample_period": 0.1}
_BEYOND = {"type": "configuration", "name": "beyond"}
_NEAR = {"type": "joint", "positions": [0.1, -0.35, 0.3]}
_ASIDE = {"position": [0.1, -0.4, 0.0]}


def plan(
    name: str, goal: Any, scene: str = "square", group: str | list[str] = "body", **options: Any
) -> Call:
    """Return a call for a plan that is waited for, with time for all and few samples."""
    wait = options.pop("wait", "?wait=60")
    headers = options.pop("headers", {})
    options["search"] = {**_PATIENT, **options.get("search", {})}
    options["retime"] = {**_COARSE, **options.get("retime", {})}
    where = scene if scene.startswith("scn_") else From(scene)
    body = {"scene": where, "group": group, "goal": goal, "seed": 3, **options}
    return post(name, f"/v1/plans{wait}", body, headers=headers)


_GOALS = (
    plan("joint", _NEAR),
    plan("joints", {"type": "joint", "positions": [[0.3, 0.02, 0], [0.1, -0.35, 0.3]]}),
    plan("configuration", _BEYOND),
    plan("pose", {"type": "pose", "poses": [_ASIDE]}),
    plan("pose_with_approach", {"type": "pose", "poses": [_ASIDE], "approach": [0.02, 0, 0]}),
    plan(
        "pose_by_a_metric",
        {"type": "pose", "poses": [_ASIDE], "metric": {"tolerance": 0.01}},
    ),
    plan(
        "region",
        {"type": "region", "pose": _ASIDE, "tolerance": {"position": [0.02, 0.02, 0]}},
    ),
    plan("relative", {"type": "relative", "displacement": {"position": [-0.1, 0, 0]}}),
    plan("straight", {"type": "line", "displacement": {"vector": [-0.1, 0.0, 0]}}),
    plan("path", {"type": "path", "poses": [_ASIDE, {"position": [0.2, -0.35, 0.0]}]}),
)
_KEEP_IN = {
    "type": "keep_in",
    "frame": "body::body",
    "box": {"size": [0.9, 0.5, 0.5], "pose": {"position": [0, -0.3, 0]}},
}
_ZONE = {
    "name": "slow",
    "frame": "body::body",
    "box": {"size": [0.1, 0.4, 0.4], "pose": {"position": [0.2, -0.35, 0.0]}},
    "speed": 0.1,
}
_OPTIONS = (
    plan("constrained", _NEAR, path_constraints=[_KEEP_IN]),
    plan(
        "limited",
        _NEAR,
        retime={
            "tool_limits": [{"frame": "body::body", "speed": 0.2}],
            "speed_zones": [_ZONE],
            "effort": True,
            "velocity_scale": 0.5,
        },
        certify={"robustness": True},
    ),
    plan("clearance_wish", _BEYOND, refine={"clearance": {"distance": 0.05, "weight": 10.0}}),
    plan("counted_samples", _NEAR, retime={"sample_period": None, "num_points": 5}),
    plan("ruckig", _NEAR, retime={"method": "ruckig", "deviation": 0.0}),
    plan("explained", _BEYOND, retime={"explain": True}, refine={"method": "none"}),
    plan("kept_graph", _BEYOND, search={"keep_graph": True, "planner": "RRT"}),
    plan("no_refinement", _BEYOND, refine={"method": "none"}, margin=0.005),
    plan("two_planners", _BEYOND, search={"planner": ["RRTConnect", "PRM"], "attempts": 2}),
    plan("roadmap", _BEYOND, search={"roadmap": {"states": 200, "neighbours": 6}}),
    plan("car", {"type": "configuration", "name": "ahead"}, "street", "car"),
    plan("arm_plan", {"type": "configuration", "name": "ready"}, "arm", "arm"),
    plan("repeated", _NEAR, headers={"idempotency-key": "once"}),
    plan("repetition", _NEAR, headers={"idempotency-key": "once"}),
    plan("preferred_wait", _NEAR, wait="", headers={"prefer": "wait=60"}),
)
_AWAY = {"type": "pose", "poses": [{"position": [9, 0, 0]}]}
_FAILURES = (
    plan("start_in_collision", _NEAR, start=[0.3, 0, 0]),
    plan("start_outside_limits", _NEAR, start=[0.3, -0.9, 0]),
    plan("goal_in_collision", {"type": "joint", "positions": [0.3, 0, 0]}),
    plan("goal_outside_limits", {"type": "joint", "positions": [0.3, 0.9, 0]}),
    plan("goal_unreachable", _AWAY, ik={"max_trials": 5}),
    plan("goal_too_near", {"type": "joint", "positions": [0.1, -0.2, 0.0]}, margin=0.15),
    plan("goal_violates_constraint", _BEYOND, path_constraints=[_KEEP_IN]),
    plan("line_blocked", {"type": "line", "displacement": {"vector": [0, 0.6, 0]}}),
    plan("too_short_a_duration", _NEAR, retime={"duration": 0.01}),
    plan("too_long_stops", _NEAR, certify={"max_stopping_time": 0.001}),
    plan("too_many_samples", _NEAR, retime={"velocity_scale": 1e-6}),
)
_MOST = {"planner": "RRTConnect", "allowed_planning_time": 600.0}
_OUT = {"type": "joint", "positions": [-0.3, 0.3, 0.0]}
# One plan runs, one waits, and the queue takes no further one.
_QUEUE = (
    plan("endless", _OUT, "cell", wait="", search=_MOST),
    get("running", "/v1/plans/{endless}", until=("stage", "search"), is_moving=True),
    plan("waiting", _NEAR, wait=""),
    get("queued", "/v1/plans/{waiting}"),
    plan("queue_full", _NEAR, wait=""),
    post("cancel_waiting", "/v1/plans/{waiting}/cancel", is_moving=True),
    get("canceled_waiting", "/v1/plans/{waiting}", until=("state", "canceled")),
    get("events_of_waiting", "/v1/plans/{waiting}/events"),
    post("cancel_running", "/v1/plans/{endless}/cancel", is_moving=True),
    get("canceled_running", "/v1/plans/{endless}", until=("state", "canceled")),
    post("cancel_again", "/v1/plans/{endless}/cancel"),
)
PLAN_CALLS = (
    *_GOALS,
    *_OPTIONS,
    *_FAILURES,
    *_QUEUE,
    get("plan", "/v1/plans/{configuration}"),
    get("failed_plan", "/v1/plans/{goal_in_collision}"),
    get("events", "/v1/plans/{configuration}/events"),
    get("last_events", "/v1/plans/{configuration}/events", headers={"last-event-id": "3"}),
    get("events_of_a_failure", "/v1/plans/{goal_in_collision}/events"),
    get("graph", "/v1/plans/{kept_graph}/graph"),
    get("plans", "/v1/plans?limit=3"),
    get("failed_plans", "/v1/plans?state=failed&limit=2"),
    get("plans_of_a_scene", "/v1/plans?scene={cell}"),
    post("reverse", "/v1/plans/{configuration}/reverse?wait=60"),
    get("view", "/v1/scenes/{square}/view.html"),
    get("failure_page", "/v1/plans/{goal_in_collision}/failure.html"),
    get("failure_page_of_a_motion", "/v1/plans/{configuration}/failure.html"),
    get("report", "/v1/plans/{configuration}/report.html"),
    get("bundle", "/v1/plans/{configuration}/bundle.zip"),
    get("bundle_of_a_failure", "/v1/plans/{goal_in_collision}/bundle.zip"),
)
