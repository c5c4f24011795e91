"""Plans that fail, each for another reason, in `ur5e_pickup` and in a maze whose way is closed."""

from collections.abc import Iterator
from typing import Any

from benchmarks.error_runs.asking import Asking, bundled
from benchmarks.error_runs.made import Made, Page

_IN_BOX = [0, -0.5, 1.2, -2.2, -1.57, 0]
_BEYOND = [6.5, -1.57, 1.57, -1.57, -1.57, 0]
_ABOVE_CAN = [0.310, -1.226, 1.824, -2.169, -1.571, -1.261]
_READY = {"type": "configuration", "name": "ready"}
_PICK: dict[str, Any] = {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "pick"}]}
_AROUND_CAN = {"size": [0.2, 0.2, 0.3], "pose": {"position": [0.5, 0.3, 0.1]}}


def _keep_out(box: dict[str, Any]) -> list[dict[str, Any]]:
    return [{"type": "keep_out", "frame": "arm::tcp", "box": box}]


# What `ur5e_pickup` cannot be asked for, by the code of the answer.
_REQUESTS: dict[str, dict[str, Any]] = {
    "start_in_collision": {"start": _IN_BOX, "goal": _READY},
    "start_too_near": {"goal": _READY, "margin": 0.09},
    "start_out_of_limits": {"start": _BEYOND, "goal": _READY},
    "start_violates_constraint": {
        "goal": _READY,
        "path_constraints": _keep_out({"size": [2, 2, 2]}),
    },
    "goal_out_of_limits": {"goal": {"type": "joint", "positions": _BEYOND}},
    "goal_in_collision": {"goal": {"type": "joint", "positions": _IN_BOX}},
    "goal_too_near": {"goal": {"type": "joint", "positions": _ABOVE_CAN}, "margin": 0.02},
    "goal_unreachable": {"goal": {"type": "pose", "poses": [{"position": [0.6, 0.8, 0.8]}]}},
    "goal_violates_constraint": {"goal": _PICK, "path_constraints": _keep_out(_AROUND_CAN)},
    "approach_blocked": {"goal": {**_PICK, "approach": [0, 0, 0.3]}},
    "line_blocked": {
        "goal": {"type": "line", "displacement": {"vector": [0, 0, -0.6], "frame": "world"}}
    },
    "not_certified": {"goal": _PICK, "certify": {"max_stopping_time": 0.001}},
    "retiming_failed": {"goal": _PICK, "retime": {"duration": 0.1}},
}
# Nothing is to be seen of these.
_UNSEEN = {"retiming_failed"}
# How `maze_2d` is searched whose only way is closed, by the code of the answer.
_CLOSED: dict[str, dict[str, Any]] = {
    "no_path_found": {"allowed_planning_time": 20.0, "solve_time": 0.5},
    "deadline_exceeded": {"allowed_planning_time": 1.0},
}
_DOOR = {
    "name": "door",
    "shape": {"box": [0.3, 0.02, 0.06]},
    "pose": {"position": [-0.37, -0.18, 0.03]},
}


def plans(asking: Asking) -> Iterator[Made]:
    """Yield what fails so."""
    pickup = asking.scene(bundled("ur5e_pickup"))
    for code, request in _REQUESTS.items():
        yield _failed(asking, code, {"scene": pickup, "group": "arm", **request})
    maze = asking.scene(bundled("maze_2d"))
    asking.edited(maze, {"op": "add", "object": _DOOR})
    through = {"scene": maze, "group": "body", "goal": {"type": "configuration", "name": "exit"}}
    for code, search in _CLOSED.items():
        yield _failed(asking, code, {**through, "search": {"approximate": True, **search}})


def _failed(asking: Asking, code: str, request: dict[str, Any]) -> Made:
    body = {**request, "seed": 7}
    plan = asking.done("POST", "/v1/plans?wait=60", body)

    def page() -> Page:
        return Page(asking.http.get(f"/v1/plans/{plan['id']}/failure.html").text)

    answer = plan["failure"] or {"code": plan["state"]}
    return Made(code, "POST /v1/plans?wait=60", body, answer, None if code in _UNSEEN else page)
