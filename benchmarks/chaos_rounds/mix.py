"""What is asked for: plans of many kinds in scenes that stay, motions in scenes of their own."""

import random
from dataclasses import dataclass
from typing import Any

import yaml

import planning

ARM = {"name": "lone_arm", "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}]}
_WALL = {"name": "wall", "shape": {"box": [0.02, 9, 0.2]}, "pose": {"position": [0, 0, 0]}}
_WALLED = {
    "name": "walled",
    "robots": [{"name": "body", "model": "planar_l", "positions": [-0.35, -0.3, 0]}],
    "objects": [_WALL],
}
_NONE = {"method": "none"}
_PATIENT = {"allowed_planning_time": 60.0}
_SHORT = {"allowed_planning_time": 2.0}
_UPRIGHT = {"group": "arm", "goal": {"type": "configuration", "name": "upright"}}
# There is no way through the wall, which no planner knows: it is searched for until it is canceled.
ENDLESS = {
    "group": "body",
    "goal": {"type": "joint", "positions": [0.3, -0.3, 0.0]},
    "search": {"allowed_planning_time": 600.0, "attempts": 100, "solve_time": 2.0},
}
# Seeds of plans that hang in native code, and that break the process that makes them (`poison`).
HANGS, SEGFAULTS = 2**31 + 1, 2**31 + 2
CONFIGURATIONS = ("home", "ready", "upright")
# An arm that reaches through the table.
_INSIDE = [0.0, 0.4, 0.4, 0.0, 0.0, 0.0]


@dataclass(frozen=True)
class Kind:
    """A kind of plan: the scene that it is in, and what its request says besides."""

    scene: str
    fields: dict[str, Any]
    is_endless: bool = False


def scenes() -> dict[str, dict[str, Any]]:
    """Return the documents of the scenes that all clients plan in."""
    folder = planning.bundled_folder("scenes")
    names = ("ur5e_pickup", "maze_2d")
    read = {name: (folder / f"{name}.scene.yaml").read_text(encoding="utf-8") for name in names}
    bundled = {name: yaml.safe_load(text) for name, text in read.items()}
    return {"arm": ARM, "walled": _WALLED, **bundled}


def kinds() -> list[tuple[int, Kind]]:
    """Return kinds of plans, each with how often it comes among all."""
    pick = {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "pick"}]}
    joint = {"type": "joint", "positions": _INSIDE}
    return [
        (4, Kind("arm", {"group": "arm", "goal": _named("ready"), "refine": _NONE})),
        (3, Kind("arm", _UPRIGHT)),
        (2, Kind("arm", {"group": "arm", "goal": _named("ready"), "retime": {"method": "ruckig"}})),
        (2, Kind("ur5e_pickup", {"group": "arm", "goal": pick, "refine": _NONE})),
        (2, Kind("maze_2d", {"group": "body", "goal": _named("exit"), "refine": _NONE})),
        (1, Kind("ur5e_pickup", {"group": "arm", "goal": joint})),
        (2, Kind("walled", ENDLESS, is_endless=True)),
        (1, Kind("arm", {**_UPRIGHT, "seed": HANGS, "search": _SHORT})),
        (1, Kind("arm", {**_UPRIGHT, "seed": HANGS}, is_endless=True)),
        (1, Kind("arm", {**_UPRIGHT, "seed": SEGFAULTS})),
    ]


def a_plan(rng: random.Random, ids: dict[str, str]) -> tuple[dict[str, Any], bool]:
    """Return the request of some plan, and whether it has to be canceled to end.

    Args:
        rng: Decides.
        ids: Of the scenes, by name.
    """
    weights, choices = zip(*kinds(), strict=True)
    [kind] = rng.choices(choices, weights)
    # Few seeds, so that many jobs have one reference.
    fields = {"search": _PATIENT, "seed": rng.randrange(3), **kind.fields}
    return {"scene": ids[kind.scene], **fields}, kind.is_endless


def to_configuration(scene: str, name: str, rng: random.Random) -> dict[str, Any]:
    """Return the request of a plan from where an arm is to a configuration by name."""
    refine = rng.choice([_NONE, {"method": "trajopt"}])
    request = {"scene": scene, "group": "arm", "goal": _named(name), "refine": refine}
    return {**request, "search": _PATIENT, "seed": rng.randrange(1000)}


def _named(name: str) -> dict[str, str]:
    return {"type": "configuration", "name": name}
