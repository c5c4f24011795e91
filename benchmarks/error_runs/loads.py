"""Executions that a load disturbs: a crate whose weight no limit of the plan took into account."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.error_runs.asking import Asking, bundled
from benchmarks.error_runs.made import Made
from benchmarks.error_runs.stills import Shown

_CRATE = [0.2, 0.2, 0.2]
# Between the tool and the crate, so that they do not touch [m].
_GAP = 0.005
_GREEN = "Green: where the motion has the arm at that time."
_OUT, _ASIDE = [0.25, 0.0, 0.0], [0.0, 0.2, 0.0]


@dataclass(frozen=True)
class _Load:
    """What is carried.

    Attributes:
        mass: Of the crate [kg].
        height: Of the tool before it moves [m].
        along: Where the tool is to move, in world [m].
    """

    mass: float
    height: float
    along: list[float]


def loads(asking: Asking) -> Iterator[Made]:
    """Yield what ends so."""
    yield _carried(
        asking,
        "torque_limit_reached",
        _Load(12.7, 0.4, _OUT),
        notes=[
            "The crate weighs 12.7 kg, which the plan did not reckon with.",
            "Red: the upper arm, which that joint has to lift.",
        ],
        marked=["arm::upper_arm_link"],
    )
    yield _carried(
        asking,
        "tracking_lost",
        _Load(40.0, 0.4, _ASIDE),
        notes=["The crate weighs 40 kg: the motors cannot hold it.", _GREEN],
    )
    yield _carried(
        asking,
        "contact",
        _Load(60.0, 0.23, _ASIDE),
        notes=["The crate weighs 60 kg: the arm sank with it onto the table.", _GREEN],
    )


def _carried(
    asking: Asking,
    code: str,
    load: _Load,
    notes: list[str],
    marked: Sequence[str] = (),
) -> Made:
    """Move a crate that hangs below the tool along a line."""
    scene = _holding(asking, load.mass, load.height)
    line = {"type": "line", "displacement": {"vector": load.along}}
    plan = asking.planned({"scene": scene, "group": "arm", "goal": line})
    body = {"plan": plan["id"]}
    ended = asking.executed(body)
    failure = ended["failure"]
    at = _status_at(asking, ended["id"])
    motion = plan["result"]["trajectory"]
    nearest = min(range(len(motion["times"])), key=lambda i: abs(motion["times"][i] - at["time"]))
    shown = Shown(
        asking,
        scene,
        code,
        [failure["detail"], *notes],
        {"arm": at["positions"]},
        ghost={"arm": motion["positions"][nearest]} if _GREEN in notes else None,
        marked=[*failure["evidence"].get("pair", ()), *marked],
    )
    return Made(code, "POST /v1/executions", body, failure, shown.page)


def _holding(asking: Asking, mass: float, height: float) -> str:
    """Return a scene whose arm holds a crate, with the tool at a height [m]."""
    document = bundled("ur5e_pickup")
    document["objects"] = [each for each in document["objects"] if each["name"] == "table"]
    del document["frames"]
    empty = asking.scene(document)
    document["robots"][0]["positions"] = asking.reaching(empty, "arm", [0.5, -0.1, height])
    crate = {
        "name": "crate",
        "shape": {"box": _CRATE},
        "pose": {"position": [0.5, -0.1, height - _CRATE[2] / 2 - _GAP]},
        "movable": True,
        "mass": mass,
        "color": [0.62, 0.47, 0.31],
    }
    scene = asking.scene({**document, "objects": [*document["objects"], crate]})
    asking.edited(scene, {"op": "attach", "object": "crate", "frame": "arm::tcp"})
    return scene


def _status_at(asking: Asking, execution: str) -> Mapping[str, Any]:
    """Return the first status that is no longer `executing`: it was measured as it failed."""
    text = asking.http.get(f"/v1/executions/{execution}/events").text.replace("\r\n", "\n")
    blocks = [block.splitlines() for block in text.split("\n\n") if "event: status" in block]
    told = [
        json.loads(next(line for line in block if line.startswith("data: "))[6:])
        for block in blocks
    ]
    return next(each for each in told if each["state"] in {"aborting", "aborted"})
