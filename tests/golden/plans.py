"""The plans of the golden set: all bundled scenes, goal types, constraints and retimers."""

from collections.abc import Iterator
from typing import Any

type Request = dict[str, Any]

_ALLOWED = {"allowed_planning_time": 120.0}
_DOWN = {"rpy": [3.141592653589793, 0, 0]}
_UPRIGHT: Request = {"type": "orientation", "frame": "arm::tcp", "axis": [0, 0, 1]}
_UPRIGHT |= {"direction": [0, 0, -1], "tolerance": 0.4}

# Name of a scene -> its group, and goals by name.
_GOALS: dict[str, tuple[str, dict[str, Request]]] = {
    "ur5e_pickup": (
        "arm",
        {
            "configuration": {"type": "configuration", "name": "stowed"},
            "joint": {"type": "joint", "positions": [0.3, -1.2, 1.5, -1.8, -1.57, 0.4]},
            "pose": {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "pick"}]},
            "approach": {
                "type": "pose",
                "poses": [{"position": [0, 0, 0], "frame": "pick"}],
                "approach": [0, 0, -0.1],
                "retreat": [0, 0, -0.05],
            },
            "region": {
                "type": "region",
                "pose": {"position": [0.45, 0.25, 0.4], **_DOWN},
                "tolerance": {"position": [0.05, 0.05, 0], "rotation": [0.1, 0.1, 0]},
                "free_axes": ["rz"],
            },
            "relative": {"type": "relative", "displacement": {"position": [0, 0, 0.05]}},
            "line": {"type": "line", "displacement": {"vector": [0, 0, 0.05]}},
            "path": {
                "type": "path",
                "poses": [
                    {"position": [0.45, 0.30, 0.35], **_DOWN},
                    {"position": [0.45, 0.20, 0.35], **_DOWN},
                    {"position": [0.40, 0.20, 0.40], **_DOWN},
                ],
            },
            "unreachable": {"type": "pose", "poses": [{"position": [3, 0, 0.5]}]},
            "in collision": {"type": "pose", "poses": [{"position": [0.5, 0.3, -0.1], **_DOWN}]},
        },
    ),
    "irb120_cell": (
        "arm",
        {
            "pose": {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "place"}]},
            "approach": {
                "type": "pose",
                "poses": [{"position": [0, 0, 0], "frame": "pick"}],
                "approach": [0, 0, -0.1],
            },
        },
    ),
    "panda_shelf": (
        "panda",
        {
            name: {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": name}]}
            for name in ("upper", "lower")
        },
    ),
    "two_arms": (
        "both",
        {"pose": {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "above_bolt"}]}},
    ),
    "maze_2d": ("body", {"configuration": {"type": "configuration", "name": "exit"}}),
    "window_3d": ("body", {"configuration": {"type": "configuration", "name": "beyond"}}),
    "parallel_parking": (
        "car",
        {name: {"type": "configuration", "name": name} for name in ("parked", "passed")},
    ),
}

# What a plan from the home of the UR5e to `stowed` is asked beyond its goal.
_OPTIONS: dict[str, Request] = {
    "no refinement": {"refine": {"method": "none"}},
    "ruckig": {"retime": {"method": "ruckig"}},
    "no refinement, ruckig": {"refine": {"method": "none"}, "retime": {"method": "ruckig"}},
    "slow tool": {"retime": {"tool_limits": [{"frame": "arm::tcp", "speed": 0.25}]}},
    "effort": {"retime": {"effort": True}},
    "margin": {"margin": 0.01},
    "PRM": {"search": {**_ALLOWED, "planner": "PRM"}},
    "BITstar": {"search": {**_ALLOWED, "planner": "BITstar"}},
    "orientation": {"path_constraints": [_UPRIGHT]},
    "joint limits": {
        "path_constraints": [{"type": "joint_limits", "limits": {"arm::elbow_joint": [0.5, 2.5]}}]
    },
    "locked joint": {
        "path_constraints": [{"type": "locked_joints", "joints": ["arm::wrist_3_joint"]}]
    },
    "samples": {"retime": {"sample_period": 0.05, "even_samples": True}},
}


def plans() -> Iterator[tuple[str, str, Request]]:
    """Yield name, scene and request of each plan."""
    for scene, (group, goals) in _GOALS.items():
        for name, goal in goals.items():
            request = {"group": group, "goal": goal, "search": _ALLOWED, "seed": 3}
            yield f"{scene}, {name}", scene, request
    stowed = _GOALS["ur5e_pickup"][1]["configuration"]
    for name, option in _OPTIONS.items():
        request = {"group": "arm", "goal": stowed, "search": _ALLOWED, "seed": 5, **option}
        yield f"ur5e_pickup, {name}", "ur5e_pickup", request
    band = {"type": "distance_band", "min": 0.01, "max": 0.05}
    request = {"group": "body", "goal": {"type": "configuration", "name": "exit"}}
    request |= {"search": _ALLOWED, "seed": 1, "path_constraints": [band]}
    yield "maze_2d_band, configuration", "maze_2d_band", request
