"""Summaries of robots and scenes to the wire."""

import dataclasses
from collections.abc import Sequence
from typing import Any

from planning.domain.geometry.unchecked_pair import UncheckedPair
from planning.domain.robot.joints import JointLimits
from planning.domain.robot.steering import steering_of
from planning.domain.scene.summary import GroupSummary, RobotSummary, SceneSummary
from service.api.number_conversion import bounds


def limits_wire(limits: JointLimits, blocks: list[str]) -> dict[str, Any]:
    """Return limits for the wire; what is unlimited is None."""
    return {
        "lower": bounds(limits.lower),
        "upper": bounds(limits.upper),
        "blocks": blocks,
        "velocity": bounds(limits.velocity),
        "acceleration": bounds(limits.acceleration),
        "jerk": bounds(limits.jerk),
        "effort": bounds(limits.effort),
    }


def group_wire(summary: GroupSummary, aliases: list[str]) -> dict[str, Any]:
    """Return a group for the wire."""
    group = summary.group
    cars = steering_of(group)
    return {
        "name": group.name,
        "aliases": aliases,
        "joints": [
            {
                "name": joint.name,
                "type": str(joint.type),
                "steering": dataclasses.asdict(cars[joint.name]) if joint.name in cars else None,
            }
            for joint in group.joints
        ],
        "position_names": list(group.position_names),
        "velocity_names": list(group.velocity_names),
        "tool_frames": list(group.tool_frames),
        "limits": limits_wire(summary.limits, [name for name, _ in group.blocks]),
        "configurations": {name: list(q) for name, q in summary.configurations.items()},
        "positions": list(summary.positions),
    }


def robot_wire(summary: RobotSummary) -> dict[str, Any]:
    """Return a robot for the wire, its default group first."""
    ordered = sorted(summary.groups, key=lambda name: name != summary.default_group)
    return {
        "name": summary.name,
        "description": summary.description,
        "default_group": summary.default_group,
        "groups": [
            group_wire(summary.groups[name], [f"{summary.name}::{name}"]) for name in ordered
        ],
        "bodies": list(summary.bodies),
        "sources": [{"what": what, "source": source} for what, source in summary.sources],
        "assumed": list(summary.assumed),
    }


def unchecked_wire(pairs: Sequence[UncheckedPair]) -> list[dict[str, Any]]:
    """Return pairs that are not looked at for the wire; of thousands of objects there are many."""
    return [
        {"bodies": list(pair.bodies), "reason": pair.reason, "evidence": pair.evidence}
        for pair in pairs
    ]


def scene_wire(summary: SceneSummary, aliases: dict[str, list[str]]) -> dict[str, Any]:
    """Return what a scene holds for the wire, but for pairs that are not looked at.

    Args:
        summary: Of the loaded scene.
        aliases: Other names of each group.
    """
    return {
        "digest": summary.digest,
        "groups": [
            group_wire(group, aliases.get(name, [])) for name, group in summary.groups.items()
        ],
        "frames": list(summary.frames),
        "bodies": list(summary.bodies),
        "num_pairs": summary.num_pairs,
        "assumed": list(summary.assumed),
        "warnings": list(summary.warnings),
    }
