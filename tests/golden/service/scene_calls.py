"""Calls about models and scenes: posted, edited by each operation, forgotten."""

from typing import Any

from tests.golden.service.calls import Call, get, post

SQUARE: dict[str, Any] = {
    "name": "square",
    "robots": [{"name": "body", "model": "planar_l", "positions": [0.3, -0.35, 0.0]}],
    "objects": [
        {"name": "wall", "shape": {"box": [0.8, 0.02, 0.06]}, "pose": {"position": [0.2, 0, 0.03]}},
        {
            "name": "coin",
            "shape": {"cylinder": {"radius": 0.02, "length": 0.02}},
            "pose": {"position": [-0.4, -0.4, 0.03]},
            "movable": True,
        },
    ],
    "frames": [{"name": "exit", "parent": "world", "pose": {"position": [0.3, 0.3, 0.0]}}],
    "configurations": {"beyond": {"group": "body", "positions": [0.3, 0.3, 0.0]}},
}
CAR = """
name: street
robots:
  - {name: car, model: car, positions: [-0.95, 0.0, 0.0]}
objects:
  - {name: curb, shape: {box: [2.6, 0.04, 0.03]}, pose: {position: [0.0, -0.49, 0.015]}}
configurations:
  ahead: {group: car, positions: [0.6, 0.1, 0.0]}
"""
ARM: dict[str, Any] = {
    "name": "arm",
    "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}],
    "objects": [
        {"name": "block", "shape": {"box": [0.1, 0.1, 0.1]}, "pose": {"position": [0.6, 0, 0.05]}}
    ],
    "frames": [{"name": "above", "parent": "block", "pose": {"position": [0, 0, 0.3]}}],
}
# The body stands in a room without a door.
CELL: dict[str, Any] = {
    "name": "cell",
    "robots": [{"name": "body", "model": "planar_l", "positions": [0.3, -0.3, 0.0]}],
    "objects": [
        {
            "name": f"side_{i}",
            "shape": {"box": [1.1, 0.02, 0.06] if x == 0 else [0.02, 1.1, 0.06]},
            "pose": {"position": [x, y, 0.03]},
        }
        for i, (x, y) in enumerate([(0, 0), (0.0, -0.53), (0.02, 0), (0.56, 0)])
    ],
}
_YAML = {"content-type": "application/yaml"}


def _edit(name: str, *operations: dict[str, Any], **rest: Any) -> Call:
    body = {"operations": list(operations), **rest}
    return Call(name, "PATCH", "/v1/scenes/{edited}", body)


_PEBBLE = {"name": "pebble", "shape": {"sphere": 0.02}, "pose": {"position": [-0.4, 0.4, 0.02]}}
_HELD = {"op": "attach", "object": "coin", "frame": "body::body"}

FIRST_CALLS = (
    get("models", "/v1/models"),
    get("model", "/v1/models/planar_l"),
    get("model_of_a_car", "/v1/models/car"),
    get("model_of_an_arm", "/v1/models/ur5e"),
    get("planners", "/v1/planners"),
    get("health", "/healthz"),
    get("no_scenes", "/v1/scenes"),
    get("no_plans", "/v1/plans"),
    post("square", "/v1/scenes", SQUARE),
    post("street", "/v1/scenes", CAR.encode(), headers=_YAML),
    post("arm", "/v1/scenes", ARM),
    post("cell", "/v1/scenes", CELL),
    post("edited", "/v1/scenes", {**SQUARE, "name": "edited"}),
    get("scene", "/v1/scenes/{square}"),
    get("geometry", "/v1/scenes/{square}/geometry"),
    get("no_mesh", f"/v1/scenes/{{square}}/geometry/{'0' * 64}.glb"),
    _edit("add", {"op": "add", "object": _PEBBLE}),
    _edit("move", {"op": "move", "object": "pebble", "pose": {"position": [0.4, 0.4, 0.02]}}),
    _edit("remove", {"op": "remove", "object": "pebble"}, revision=3),
    _edit("attach", _HELD),
    _edit("detach", {"op": "detach", "object": "coin"}),
    _edit("allow", {"op": "allow", "pair": ["body::body", "wall"]}),
    _edit("forbid", {"op": "forbid", "pair": ["body::body", "wall"]}),
    _edit("set_positions", {"op": "set_positions", "robot": "body", "positions": "home"}),
    _edit("two_operations", _HELD, {"op": "detach", "object": "coin"}),
    _edit("revision_conflict", {"op": "remove", "object": "coin"}, revision=2),
    get("old_revision", "/v1/scenes/{edited}?revision=1"),
    get("scenes", "/v1/scenes?limit=2"),
    get("last_scenes", "/v1/scenes?limit=2&cursor=3"),
    Call("delete", "DELETE", "/v1/scenes/{edited}"),
    get("deleted", "/v1/scenes/{edited}"),
)
