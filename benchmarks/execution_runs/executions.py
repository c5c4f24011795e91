"""Plans and executions over HTTP, as the sections of the benchmark ask for them."""

from typing import Any

import planning
from benchmarks.service_load.host import Host
from benchmarks.serving.server import pause

# Scene, group and goal of each; a goal is a frame that the tool shall reach, or a configuration.
QUERIES: tuple[tuple[str, str, dict[str, str]], ...] = (
    ("ur5e_pickup", "arm", {"frame": "pick"}),
    ("panda_shelf", "panda", {"frame": "upper"}),
    ("irb120_cell", "arm", {"frame": "above_pick"}),
    ("two_arms", "left", {"frame": "above_bolt"}),
    ("maze_2d", "body", {"configuration": "exit"}),
    ("window_3d", "body", {"configuration": "beyond"}),
    ("parallel_parking", "car", {"configuration": "parked"}),
)
_PERIOD = 0.01


def posted(host: Host, name: str) -> str:
    """Post a bundled scene and return its id."""
    text = (planning.bundled_folder("scenes") / f"{name}.scene.yaml").read_bytes()
    kind = {"Content-Type": "application/yaml"}
    answer = host.http.post("/v1/scenes", content=text, headers=kind)
    answer.raise_for_status()
    identifier: str = answer.json()["id"]
    return identifier


def planned(host: Host, scene: str, group: str, wanted: dict[str, str]) -> dict[str, Any]:
    """Return a plan of a scene's group to a goal; its `failure` says why there is no motion."""
    if "frame" in wanted:
        goal = {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": wanted["frame"]}]}
    else:
        goal = {"type": "configuration", "name": wanted["configuration"]}
    request: dict[str, Any] = {"scene": scene, "group": group, "goal": goal, "seed": 1}
    request["search"] = {"allowed_planning_time": 30.0}
    plan: dict[str, Any] = host.post("/v1/plans?wait=60", request)
    return plan


def begun(host: Host, plan: dict[str, Any], **terms: Any) -> str:
    """Begin to carry out a plan, wait until it moves, and return the execution's id."""
    execution: str = host.post("/v1/executions", {"plan": plan["id"], **terms})["id"]
    while (now := told(host, execution))["state"] not in _ENDED:
        if (now["status"] or {}).get("time"):
            break
        pause(_PERIOD)
    return execution


def told(host: Host, execution: str) -> dict[str, Any]:
    """Return an execution as it is now."""
    found: dict[str, Any] = host.http.get(f"/v1/executions/{execution}").json()
    return found


def ended(host: Host, execution: str) -> dict[str, Any]:
    """Return an execution once it has ended."""
    while (now := told(host, execution))["state"] not in _ENDED:
        pause(_PERIOD)
    return now


_ENDED = {"succeeded", "canceled", "aborted"}
