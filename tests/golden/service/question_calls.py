"""Calls that ask a scene: check, fk, ik, line."""

from typing import Any

from tests.golden.service.calls import Call, post

# No deadline may cut anything short.
_PATIENT = {"allowed_time": 60.0}
_DOWN = {"rpy": [3.141592653589793, 0, 0]}
_ABOVE = {"position": [0, 0, 0], "frame": "above", **_DOWN}


def _ask(name: str, what: str, **body: Any) -> Call:
    return post(name, f"/v1/scenes/{{square}}/{what}", {"group": "body", **body})


def _ask_arm(name: str, what: str, **body: Any) -> Call:
    return post(name, f"/v1/scenes/{{arm}}/{what}", {"group": "arm", **_PATIENT, **body})


QUESTION_CALLS = (
    _ask("check", "check", configurations=[[0.3, -0.35, 0], [0.3, 0, 0], [0.9, 0, 0]]),
    _ask("check_with_a_margin", "check", configurations=[[0.3, -0.35, 0]], margin=0.4),
    _ask("fk", "fk", configurations=[[0.1, 0.2, 0.3]]),
    _ask("fk_of_frames", "fk", configurations=[[0.1, 0.2, 0.3]], frames=["exit", "body::body"]),
    _ask_arm("ik", "ik", goal={"type": "pose", "poses": [_ABOVE]}, seed=1),
    _ask_arm(
        "ik_out_of_reach",
        "ik",
        goal={"type": "pose", "poses": [{"position": [9, 0, 0]}]},
        ik={"max_trials": 20},
    ),
    _ask_arm(
        "ik_of_a_region",
        "ik",
        goal={"type": "region", "pose": _ABOVE, "tolerance": {"position": [0.02, 0.02, 0]}},
        ik={"max_configurations": 2, "max_trials": 20},
    ),
    _ask_arm("line", "line", displacement={"vector": [0, 0, 0.05]}, poses=True),
    _ask_arm("line_that_stops", "line", displacement={"vector": [2, 0, 0]}, max_step=0.2),
)
