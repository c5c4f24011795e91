"""Grasps of `ur5e_pickup` that fail: a can beside the fingers, and one that slips out of them."""

from collections.abc import Iterator
from typing import Any

from benchmarks.error_runs.asking import Asking, bundled
from benchmarks.error_runs.made import Made
from benchmarks.error_runs.stills import Shown

_EXECUTE = "POST /v1/executions"
_GRIPPER = "arm::gripper"
# The can is taken for where it was [m].
_ASIDE = 0.07
# From beside the can, so that the box does not hide it.
_NEAR = ((0.58, 0.72, 0.2), (0.53, 0.3, 0.12))
_CAN_MASS = 0.3


def grasps(asking: Asking) -> Iterator[Made]:
    """Yield what ends so."""
    yield _grasp_missed(asking)
    yield _grasp_lost(asking)


def _grasp_missed(asking: Asking) -> Made:
    """Close the fingers beside a can."""
    document = _at_can(asking)
    _can(document)["pose"]["position"][0] += _ASIDE
    scene = asking.scene(document)
    body = {"gripper": {"scene": scene, "group": _GRIPPER, "grasp": {"object": "can"}}}
    problem = asking.json("POST", "/v1/executions", body)
    shown = Shown(
        asking,
        scene,
        "grasp_missed",
        [
            problem["detail"],
            f"The can stands {1000 * _ASIDE:.0f} mm beside the fingers that shall hold it.",
        ],
        {"arm": document["robots"][0]["positions"]},
        marked=["can"],
        camera=_NEAR,
    )
    return Made("grasp_missed", _EXECUTE, body, problem, shown.page)


def _grasp_lost(asking: Asking) -> Made:
    """Lift a can that is hardly pressed."""
    document = _at_can(asking)
    _can(document)["mass"] = _CAN_MASS
    scene = asking.scene(document)
    grasp = {"object": "can", "by": "contact", "friction": 0.092, "slip": 0.02}
    gripper = {"scene": scene, "group": _GRIPPER, "grasp": grasp, "force": 9.0}
    asking.executed({"gripper": gripper, "speed": 5})
    line = {"type": "line", "displacement": {"vector": [0, 0, 0.15]}}
    plan = asking.planned({"scene": scene, "group": "arm", "goal": line})
    body = {"plan": plan["id"]}
    ended = asking.executed({**body, "speed": 2})
    failure = ended["failure"]
    shown = Shown(
        asking,
        scene,
        "grasp_lost",
        [
            failure["detail"],
            "Red: the can where it was measured last. The fingers pressed it with 9 N.",
        ],
        {"arm": ended["status"]["positions"]},
        marked=["can"],
        camera=_NEAR,
    )
    return Made("grasp_lost", _EXECUTE, body, failure, shown.page)


def _at_can(asking: Asking) -> dict[str, Any]:
    """Return the scene with the open gripper around the can."""
    document = bundled("ur5e_pickup")
    scene = asking.scene(document)
    goal = {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "pick"}]}
    body = {"group": "arm", "goal": goal, "ik": {"max_configurations": 1}, "seed": 1}
    found = asking.done("POST", f"/v1/scenes/{scene}/ik", body)
    document["robots"][0]["positions"] = found["configurations"][0]["positions"]
    return document


def _can(document: dict[str, Any]) -> dict[str, Any]:
    can: dict[str, Any] = next(each for each in document["objects"] if each["name"] == "can")
    return can
