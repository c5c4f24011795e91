"""unlimited_joints(): joints without position limits in a description whose type has limits."""

import math
from collections.abc import Iterator
from xml.etree import ElementTree as ET

_TYPES_WITH_LIMITS = {"revolute", "prismatic"}
# SDF's value for no limit.
_SDF_UNLIMITED = 1e15


def unlimited_joints(models: list[ET.Element]) -> tuple[str, ...]:
    """Return the revolute and prismatic joints without position limits in URDF or SDF.

    Those of type `continuous` are unlimited by design. MJCF is not checked: it has no such type,
    and a joint without `range` is usual there.
    """
    names = (
        joint.get("name", "")
        for model in models
        if model.tag != "mujoco"
        for joint in model.iter("joint")
        if joint.get("type") in _TYPES_WITH_LIMITS
        and any(not _is_finite(bound) for bound in _bounds(joint))
    )
    return tuple(dict.fromkeys(names))


def _bounds(joint: ET.Element) -> Iterator[str]:
    limits = list(joint.iter("limit"))
    for side in ("lower", "upper"):
        found = [limit.get(side) or limit.findtext(side) for limit in limits]
        yield next((text for text in found if text), "inf")


def _is_finite(text: str) -> bool:
    try:
        number = float(text)
    except ValueError:
        return True  # the parser reports it
    return math.isfinite(number) and abs(number) < _SDF_UNLIMITED
