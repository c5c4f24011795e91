"""Relaxations: what can be asked instead of a request that failed, each a request of its own."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from service.studio.texts import short

# Of a tolerance that is said to be enough: a little more, for it is found by a search.
_ROOM = 1.02
# Of the planning time that was too short.
_LONGER = 4.0
_TOO_SHORT = {"no_path_found", "deadline_exceeded", "not_certified"}


@dataclass(frozen=True)
class Relaxation:
    """One thing to ask instead.

    Attributes:
        text: What it changes.
        request: Of a plan.
        operations: That the scene needs first.
    """

    text: str
    request: dict[str, Any]
    operations: list[dict[str, Any]] = field(default_factory=list[dict[str, Any]])


def relaxations_of(
    failure: Mapping[str, Any], request: Mapping[str, Any], objects: Collection[str]
) -> list[Relaxation]:
    """Return what can be asked instead, what changes least first.

    Args:
        failure: Of a plan, as the API has it.
        request: That failed, with its `search`.
        objects: Names of objects that may be removed.
    """
    evidence = failure["evidence"] or {}
    told = evidence.get("relaxation") or {}
    nearest = evidence.get("nearest") or {}
    found = [
        *_of_margin(told, request),
        *_of_nearest(nearest, request),
        *_of_tolerance(told, request),
        *_of_removal(told, request, objects),
    ]
    if failure["code"] in _TOO_SHORT:
        search = request["search"]
        seconds = _LONGER * float(search["allowed_planning_time"])
        longer = {**search, "allowed_planning_time": seconds, "attempts": 4}
        found.append(Relaxation(f"Search for {seconds:.0f} s", {**request, "search": longer}))
    return found


def _of_margin(told: Mapping[str, Any], request: Mapping[str, Any]) -> list[Relaxation]:
    margin = told.get("margin")
    if margin is None:
        return []
    text = f"Keep {1000 * margin:.1f} mm apart"
    return [Relaxation(text, {**request, "margin": margin})]


def _of_nearest(nearest: Mapping[str, Any], request: Mapping[str, Any]) -> list[Relaxation]:
    positions = nearest.get("positions")
    if positions is None:
        return []
    goal = {"type": "joint", "positions": [positions]}
    away = nearest.get("translation_error")
    if away is None:
        text = "Go to the nearest that is free"
    else:
        turned = math.degrees(nearest.get("rotation_error") or 0.0)
        text = f"Go as near as can be: {1000 * away:.0f} mm, {turned:.0f}° off"
    return [Relaxation(text, {**request, "goal": goal})]


def _of_tolerance(told: Mapping[str, Any], request: Mapping[str, Any]) -> list[Relaxation]:
    tolerance = told.get("tolerance")
    if tolerance is None or request["goal"]["type"] != "pose":
        return []
    position = [_ROOM * x for x in tolerance["position"]]
    rotation = [min(_ROOM * x, math.pi) for x in tolerance["rotation"]]
    goal = {**request["goal"], "tolerance": {"position": position, "rotation": rotation}}
    sides = " x ".join(f"{1000 * x:.0f}" for x in position)
    text = f"Allow ± {sides} mm, {math.degrees(max(rotation)):.0f}°"
    return [Relaxation(text, {**request, "goal": goal})]


def _of_removal(
    told: Mapping[str, Any], request: Mapping[str, Any], objects: Collection[str]
) -> list[Relaxation]:
    names = told.get("remove") or []
    if not names or not set(names) <= {*objects}:
        return []
    operations = [{"op": "remove", "object": name} for name in names]
    text = f"Take {' and '.join(map(short, names))} away"
    return [Relaxation(text, dict(request), operations)]
