"""What a goal may be chosen from, and what is said of it."""

from typing import Any

import numpy as np
import viser

from service.studio.cell import Cell
from service.studio.texts import millimetres

BY_SLIDERS, BY_TOOL, BY_FORM = "joint sliders", "drag the tool", "any goal, in full"
FRAME, CONFIGURATION = "frame ", "configuration "


def goals_of(cell: Cell) -> dict[str, dict[str, Any]]:
    """Return what the goals of a cell are called, and as the API wants them; targets first."""
    frames = [frame["name"] for frame in cell.scene.document.get("frames", [])]
    found = {
        f"{FRAME}{name}": {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": name}]}
        for name in (frames if cell.group.tool_frames else [])
    }
    away = sorted(
        cell.group.configurations,
        key=lambda name: np.allclose(cell.group.configurations[name], cell.positions),
    )
    found |= {f"{CONFIGURATION}{n}": {"type": "configuration", "name": n} for n in away}
    by_hand = [BY_SLIDERS, *([BY_TOOL] if cell.group.tool_frames else []), BY_FORM]
    return found | {name: {} for name in by_hand}


def goal_to_begin_with(cell: Cell) -> dict[str, Any]:
    """Return a goal that a form can begin with: a pose of the tool, else where the group is."""
    group = cell.group
    if not group.tool_frames:
        return {"type": "joint", "positions": cell.positions.tolist()}
    frames = [frame["name"] for frame in cell.scene.document.get("frames", [])]
    if frames:
        return {"type": "pose", "poses": [{"position": [0.0, 0.0, 0.0], "frame": frames[0]}]}
    tool = group.tool_frames[0]
    row = cell.api.poses(cell.scene.id, group.name, cell.positions, [tool])[tool][0].tolist()
    return {"type": "pose", "poses": [{"position": row[:3], "quaternion": row[3:]}]}


def pose_goal(gizmo: viser.TransformControlsHandle) -> dict[str, Any]:
    """Return the goal to bring the tool to where a gizmo stands."""
    pose = {
        "position": [float(part) for part in gizmo.position],
        "quaternion": [float(part) for part in gizmo.wxyz],
    }
    return {"type": "pose", "poses": [pose]}


def praise(best: dict[str, Any], count: int) -> str:
    """Return how many configurations reach a goal, and how far the best is from everything."""
    poses = "1 arm pose reaches it" if count == 1 else f"{count} arm poses reach it"
    gap = best["clearance"]
    return poses + ("" if gap is None else f" · {millimetres(gap)} clear there")


def free(verdict: dict[str, Any]) -> str:
    """Return how far a free configuration is from everything."""
    gap = verdict["distance"]
    return "free" if gap is None else f"free · {millimetres(gap)} clear there"
