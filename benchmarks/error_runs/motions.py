"""Executions of `ur5e_pickup` that end early, or are refused, because of where things are."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.error_runs.asking import DOWN, Asking, bundled
from benchmarks.error_runs.made import Made
from benchmarks.error_runs.stills import Shown

_PICK = {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "pick"}]}
_STOWED = {"type": "configuration", "name": "stowed"}
_EXECUTE = "POST /v1/executions"
# Slow enough that an edit comes while it moves.
_SLOWLY = 0.1
# Of the motion, where a crate is put into its way.
_AHEAD = 0.6
_CRATE = [0.12, 0.12, 0.12]


def motions(asking: Asking) -> Iterator[Made]:
    """Yield what ends so."""
    yield _path_blocked(asking)
    yield _start_mismatch(asking)
    yield _schedule_not_found(asking)


def _path_blocked(asking: Asking) -> Made:
    """Put a crate where the tool is to be later."""
    scene = asking.scene(bundled("ur5e_pickup"))
    plan = asking.planned({"scene": scene, "group": "arm", "goal": _PICK})
    body = {"plan": plan["id"], "speed": _SLOWLY}
    execution = asking.done("POST", "/v1/executions", body)["id"]
    asking.moving(execution)
    rows = plan["result"]["trajectory"]["positions"]
    place = _tool(asking, scene, rows[int(_AHEAD * len(rows))])
    crate = {"name": "crate", "shape": {"box": _CRATE}, "pose": {"position": place}}
    asking.edited(scene, {"op": "add", "object": {**crate, "color": [0.62, 0.47, 0.31]}})
    ended = asking.ended(execution)
    failure = ended["failure"]
    shown = Shown(
        asking,
        scene,
        "path_blocked",
        [
            failure["detail"],
            "The crate was added while the arm moved: it stopped before it.",
            "Green: where the rest of the motion would go through the crate.",
        ],
        {"arm": ended["status"]["positions"]},
        ghost={"arm": _row_at(plan, failure["evidence"]["time"])},
        marked=["crate"],
    )
    return Made("path_blocked", _EXECUTE, body, failure, shown.page)


def _start_mismatch(asking: Asking) -> Made:
    """Execute a plan whose robot has gone elsewhere meanwhile."""
    scene = asking.scene(bundled("ur5e_pickup"))
    plan = asking.planned({"scene": scene, "group": "arm", "goal": _PICK})
    other = asking.planned({"scene": scene, "group": "arm", "goal": _STOWED})
    asking.executed({"plan": other["id"], "speed": 20})
    body = {"plan": plan["id"]}
    problem = asking.json("POST", "/v1/executions", body)
    evidence = problem["evidence"]
    shown = Shown(
        asking,
        scene,
        "start_mismatch",
        [
            problem["detail"],
            "The arm is where it was measured last.",
            "Green: where the plan begins.",
        ],
        {"arm": evidence["positions"]},
        ghost={"arm": evidence["start"]},
        camera=((1.05, 0.9, 0.75), (0.15, 0.2, 0.3)),
    )
    return Made("start_mismatch", _EXECUTE, body, problem, shown.page)


_TWO = {
    "name": "two",
    "robots": [
        {"name": "l", "model": "irb120", "base": {"position": [0, 0.35, 0]}},
        {"name": "r", "model": "irb120", "base": {"position": [0, -0.35, 0]}},
    ],
    "groups": {"both": ["l", "r"]},
}


def _schedule_not_found(asking: Asking) -> Made:
    """Have two arms reach over to where the other one ends."""
    scene = asking.scene(_TWO)
    plans = []
    for side, y in (("l", -0.05), ("r", 0.05)):
        pose = {"position": [0.38, y, 0.1], "rpy": DOWN}
        goal = {"type": "pose", "poses": [pose]}
        plans.append(asking.planned({"scene": scene, "group": side, "goal": goal}))
    body = {"scene": scene, "plans": [plan["id"] for plan in plans]}
    failure = asking.done("POST", "/v1/trajectories/schedule", body)["failure"]
    ends = {
        side: plan["result"]["goal_configuration"] for side, plan in zip("lr", plans, strict=True)
    }
    shown = Shown(
        asking,
        scene,
        "schedule_not_found",
        [
            failure["detail"],
            "Shown: the ends of both motions, in which the arms would be inside one another.",
        ],
        ends,
        marked=failure["evidence"]["pair"],
        camera=((1.15, 0.0, 0.65), (0.15, 0.0, 0.25)),
    )
    call = "POST /v1/trajectories/schedule"
    return Made("schedule_not_found", call, body, failure, shown.page)


def _tool(asking: Asking, scene: str, row: list[float]) -> list[float]:
    body = {"group": "arm", "configurations": [row], "frames": ["arm::tcp"]}
    found = asking.done("POST", f"/v1/scenes/{scene}/fk", body)["results"][0]
    place: list[float] = found["arm::tcp"]["position"]
    return place


def _row_at(plan: Any, time: float) -> list[float]:
    """Return the sample of a plan's motion that is nearest to a time."""
    motion = plan["result"]["trajectory"]
    at = int(np.argmin(np.abs(np.array(motion["times"]) - time)))
    row: list[float] = motion["positions"][at]
    return row
