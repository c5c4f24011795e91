"""unlimited_joints(): joints that a description leaves without an end, though it could say so."""

import math
from collections.abc import Iterator
from xml.etree import ElementTree as ET

_LIMITED = {"revolute", "prismatic"}
# What SDF writes for no limit at all.
_ENDLESS = 1e15


def unlimited_joints(models: list[ET.Element]) -> tuple[str, ...]:
    """Return the revolute and prismatic joints whose positions URDF or SDF do not limit.

    Those of type `continuous` are meant to have no end. MJCF is not looked at: it has no such type,
    and a joint without `range` is the usual one there.
    """
    names = (
        joint.get("name", "")
        for model in models
        if model.tag != "mujoco"
        for joint in model.iter("joint")
        if joint.get("type") in _LIMITED and any(not _is_finite(bound) for bound in _bounds(joint))
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
        return True  # the parser says what is wrong with it
    return math.isfinite(number) and abs(number) < _ENDLESS
