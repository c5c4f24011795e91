"""Calls that are refused, each for another reason."""

from typing import Any

from tests.golden.service.calls import Call, From, get, post
from tests.golden.service.plan_calls import plan
from tests.golden.service.scene_calls import SQUARE

_JSON = {"content-type": "application/json"}
_HOME = {"type": "configuration", "name": "home"}
_POSE = {"position": [0.1, -0.35, 0.0]}
_CHECK = "/v1/scenes/{square}/check"
_THING = {"name": "thing", "shape": {"box": [1, 0, 1]}}


def _raw(name: str, text: str, kind: str = "application/json", path: str = "/v1/plans") -> Call:
    return post(name, path, text.encode(), headers={"content-type": kind})


def _edit(name: str, operation: dict[str, Any], **rest: Any) -> Call:
    return Call(name, "PATCH", "/v1/scenes/{square}", {"operations": [operation], **rest})


_SCENES = (
    post("unknown_model", "/v1/scenes", {"robots": [{"name": "a", "model": "ur6"}]}),
    post("no_file", "/v1/scenes", {"robots": [{"name": "a", "model": "/nowhere/x.urdf"}]}),
    post("unknown_field_of_a_scene", "/v1/scenes", {**SQUARE, "object": []}),
    post("zero_box", "/v1/scenes", {**SQUARE, "objects": [_THING]}),
    _raw("faulty_yaml", "robots:\n  - {name: a\n", "application/yaml", "/v1/scenes"),
    _raw("scene_of_another_kind", "<scene/>", "text/xml", "/v1/scenes"),
    get("unknown_scene", "/v1/scenes/scn_nothing"),
    get("unknown_revision", "/v1/scenes/{square}?revision=99"),
    Call("delete_unknown_scene", "DELETE", "/v1/scenes/scn_nothing"),
    _edit("unknown_object", {"op": "remove", "object": "wal"}),
    _edit("unknown_operation", {"op": "burn", "object": "wall"}),
    _edit("unmovable_object", {"op": "attach", "object": "wall", "frame": "body::body"}),
    _edit("edit_of_no_revision", {"op": "remove", "object": "coin"}, revision=7),
    get("unknown_model_resource", "/v1/models/planar_m"),
)
_PLANS = (
    plan("plan_in_no_scene", _HOME, "scn_nothing"),
    plan("unknown_group", _HOME, group="bdy"),
    plan("unknown_configuration", {**_HOME, "name": "hom"}),
    plan("unknown_frame", {"type": "pose", "poses": [{**_POSE, "frame": "exti"}]}),
    plan("unknown_planner", _HOME, search={"planner": "RRTConect"}),
    plan("unknown_parameter", _HOME, search={"parameters": {"rnge": 1}}),
    plan("unknown_constraint", _HOME, path_constraints=[{"type": "upright"}]),
    plan("unknown_joint", _HOME, path_constraints=[{"type": "locked_joints", "joints": ["elbow"]}]),
    plan("unknown_field", _HOME, speed=1),
    plan("unknown_inner_field", _HOME, retime={"metod": "toppra"}),
    plan("unknown_goal", {"type": "fly"}),
    plan("wrong_count", {"type": "joint", "positions": [0, 0]}),
    plan("wrong_count_of_the_start", _HOME, start=[0] * 7),
    plan("text_for_a_number", _HOME, seed="3"),
    plan("out_of_range", _HOME, retime={"velocity_scale": 1.1}),
    plan(
        "two_rotations",
        {"type": "pose", "poses": [{**_POSE, "rpy": [0] * 3, "quaternion": [1, 0, 0, 0]}]},
    ),
    plan("two_samplings", _HOME, retime={"num_points": 5}),
    plan("several_faults", _HOME, seed=-1, margin=-1, speed=1),
    plan("negative_wait", _HOME, wait="?wait=-1"),
    plan("idempotency_conflict", _HOME, headers={"idempotency-key": "once"}),
    _raw("no_json", "{", "application/json"),
    _raw("not_finite", '{"seed": NaN}'),
    _raw("key_twice", '{"seed": 1, "seed": 2}'),
    _raw("plan_of_another_kind", "seed: 1", "application/yaml"),
    post("no_body", "/v1/plans"),
    post("too_large", "/v1/plans", b" " * (4 * 2**20 + 1), headers=_JSON),
    get("unknown_plan", "/v1/plans/pln_nothing"),
    get("unknown_state", "/v1/plans?state=done"),
    get("unknown_query", "/v1/plans?stat=failed"),
    get("query_twice", "/v1/plans?limit=1&limit=2"),
    get("faulty_cursor", "/v1/plans?cursor=x"),
    get("trajectory_of_a_failure", "/v1/plans/{goal_in_collision}/trajectory"),
    get("replay_of_a_failure", "/v1/plans/{goal_in_collision}/replay.html"),
    get("two_ways_to_sample", "/v1/plans/{configuration}/trajectory?period=0.1&points=5"),
    get("unknown_chart", "/v1/plans/{configuration}/plots/smell.svg"),
    get("no_graph", "/v1/plans/{configuration}/graph"),
    post("reverse_of_a_failure", "/v1/plans/{goal_in_collision}/reverse"),
)
_FLAT = {"times": [0, 1], "positions": [[0] * 3] * 2}
_STILL = {**_FLAT, "times": [0, 0]}
_ZERO = {"group": "a", "configurations": [[0]]}
_OWN = {"scene": From("square"), "group": "body"}
_OTHERS = (
    post("check_of_nothing", _CHECK, {"group": "body", "configurations": []}),
    post("check_of_two_numbers", _CHECK, {"group": "body", "configurations": [[0, 0]]}),
    post("check_in_no_scene", "/v1/scenes/scn_nothing/check", _ZERO),
    post("line_to_nowhere", "/v1/scenes/{square}/line", {"group": "body"}),
    post("standing_times", "/v1/trajectories/certify", {**_OWN, "trajectory": _STILL}),
    post("stop_too_late", "/v1/trajectories/stop", {**_OWN, "trajectory": _FLAT, "time": 5}),
    post("execution_of_nothing", "/v1/executions", {"plan": "pln_nothing"}),
    post("no_speed", "/v1/executions", {"plan": From("configuration"), "speed": 0}),
    get("unknown_execution", "/v1/executions/exe_nothing"),
    get("unknown_regions", "/v1/regions/reg_nothing"),
    get("unknown_path", "/v1/motions"),
    Call("unknown_method", "PUT", "/v1/plans"),
    get("unknown_host", "/v1/models", headers={"host": "elsewhere.example"}),
    get("unknown_origin", "/v1/models", headers={"origin": "https://elsewhere.example"}),
    get("unknown_query_of_health", "/healthz?verbose=1"),
)  # fmt: skip
REFUSED_CALLS = (*_SCENES, *_PLANS, *_OTHERS)
