"""Summaries of robots and scenes to the wire."""

from collections.abc import Sequence
from typing import Any

from planning.domain.geometry.unchecked_pair import UncheckedPair
from planning.domain.scene.summary import SceneSummary
from service.scenes.summary_models import Group


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
            Group.from_summary(group, aliases.get(name, [])).model_dump(mode="json")
            for name, group in summary.groups.items()
        ],
        "frames": list(summary.frames),
        "bodies": list(summary.bodies),
        "num_pairs": summary.num_pairs,
        "assumed": list(summary.assumed),
        "warnings": list(summary.warnings),
    }
