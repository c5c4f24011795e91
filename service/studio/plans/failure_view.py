"""show_failure(): a failed plan where it failed: pairs in red, the nearest pose as a ghost."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from service.studio.cell import Cell
from service.studio.view import BLOCKED


def show_failure(cell: Cell, failure: Mapping[str, Any]) -> None:
    """Draw what a failure tells of: what collides at the goal, and what is nearest to it.

    Args:
        cell: The scene.
        failure: Of the plan, as the API has it.
    """
    evidence = failure["evidence"] or {}
    relaxation = evidence.get("relaxation") or {}
    at_goal = relaxation.get("positions")
    pairs = [pair for pair in relaxation.get("obstacles") or () if pair["depth"] > 0]
    if at_goal is not None:
        poses = cell.poses(np.array(at_goal))
        cell.view.show_ghost(poses, BLOCKED)
        cell.view.mark_pairs(pairs, poses)
        return
    nearest = (evidence.get("nearest") or {}).get("positions")
    if nearest is not None:
        poses = cell.poses(np.array(nearest))
        cell.view.show_ghost(poses, BLOCKED)
        cell.view.mark_pairs([], poses)
