"""show_failure(): a failed plan where it failed: pairs in red, the nearest pose as a ghost."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from service.studio.cell import Cell
from service.studio.drawing.view import BLOCKED


def show_failure(cell: Cell, failure: Mapping[str, Any]) -> None:
    """Draw what a failure tells of: what collides at the goal, and what is nearest to it.

    Args:
        cell: The scene.
        failure: Of the plan, as the API has it.
    """
    evidence = failure["evidence"] or {}
    relaxation = evidence.get("relaxation") or {}
    at_goal = relaxation.get("positions")
    if at_goal is not None:
        poses = cell.poses(np.array(at_goal))
        cell.view.show_ghost(poses, BLOCKED)
        obstacles = relaxation.get("obstacles") or ()
        cell.view.mark_pairs([pair for pair in obstacles if pair["depth"] > 0], poses)
        return
    positions = (evidence.get("nearest") or {}).get("positions")
    poses = {} if positions is None else cell.poses(np.array(positions))
    if poses:
        cell.view.show_ghost(poses, BLOCKED)
    cell.view.mark_pairs(_pairs_of(evidence), poses)


def place_of(evidence: Mapping[str, Any] | None) -> tuple[float, dict[str, Any]] | None:
    """Return when a motion does not hold any more, and which bodies meet then.

    Args:
        evidence: Of a motion that was refused (`not_certified`).
    """
    found = evidence or {}
    if found.get("time") is None:
        return None
    depth = max(-float(found.get("value") or 0.0), 0.0)
    pair = {"bodies": found.get("pair") or [], "points": [], "depth": depth}
    return float(found["time"]), pair


def _pairs_of(evidence: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the pairs of clearance checks that failed: `where` names both bodies."""
    checks = evidence.get("checks") or ()
    return [
        {"bodies": check["where"].split("-"), "points": [], "depth": max(-check["value"], 1e-6)}
        for check in checks
        if check["name"] == "clearance" and "-" in check["where"]
    ]
