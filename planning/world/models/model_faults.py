"""Faults of a description that crash or mislead Drake: sizes, masses, limits and names."""

import math
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

from planning.errors import ModelInvalid
from planning.world.models.mjcf_file import MjcfDefaults
from planning.world.models.model_library import expansion

_POSITIVE = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "ellipsoid": ("a", "b", "c"),
}
# Sizes [m] and scales that may be zero or negative: those of MJCF's shapes, and of meshes.
_BOUNDED = {"geom": ("size", "fromto"), "mesh": ("scale",)}
# Largest size [m], as that of shapes in scenes.
_MAX_SIZE = 1e4
# Smallest limit of a velocity [rad/s or m/s] or an effort [N m or N], as in robot.yaml; 0 for none.
_MIN_LIMIT = 1e-6
# Drake's scope separator; a link with it in its own name ends the process.
_SCOPE = "::"
_SDF_KEYS = ("lower", "upper", "velocity")
_NAMED_ELEMENTS = ("link", "body", "model", "robot", "joint", "freejoint", "group")


def validate_description(file: Path, root: ET.Element) -> None:
    """Raise if a part of a description would crash or mislead Drake.

    Raises:
        ModelInvalid: A size is not positive or too large, a mass is negative, a range of limits is
            empty, a velocity limit is too small, a joint has no name, or a name contains `::`; the
            message names the element.
    """
    for element in root.iter():
        if "xacro" in element.tag:
            raise invalid(file, f"this is xacro source; expand it first: {expansion(file.name)}")
        validate_name(file, element)
        _validate_sizes(file, element)
    nameless = [joint for joint in root.findall("joint") if not joint.get("name", "_")]
    if nameless:  # its links would be joined by nothing
        ends = [e.get("link", "") for tag in ("parent", "child") for e in nameless[0].findall(tag)]
        raise invalid(file, f"the joint between {' and '.join(map(repr, ends))} has no name")
    for joint, limit in _limits(root):
        _validate_limit(file, joint, limit)


def invalid(file: Path, reason: str, **evidence: str) -> ModelInvalid:
    """Return the error for a fault of a file; the evidence names the element."""
    known = {"file": str(file), "reason": reason}
    return ModelInvalid(f"{file.name}: {reason}", {**known, **evidence})


def number_in(file: Path, tag: str, word: str) -> float:
    """Return the finite number that a word represents.

    Raises:
        ModelInvalid: It represents none; the message names the tag.
    """
    try:
        number = float(word)
    except ValueError as fault:
        raise invalid(file, f"{tag} must be a number, got {word!r}", element=tag) from fault
    if not math.isfinite(number):
        reason = f"{tag} must be a finite number, got {word!r}"
        raise invalid(file, reason, element=tag)
    return number


def validate_name(file: Path, element: ET.Element) -> None:
    """Raise if the name of an element, or of the model of an MJCF file, contains `::`.

    Raises:
        ModelInvalid: It does.
    """
    tag = _tag(element)
    name = element.get("model" if tag == "mujoco" else "name", "")
    if _SCOPE in name and tag in (*_NAMED_ELEMENTS, "mujoco"):
        reason = f"{tag} {name!r}: a name must not contain {_SCOPE!r}, which separates a robot "
        raise invalid(file, reason + "from its parts", element=name)


def _tag(element: ET.Element) -> str:
    return element.tag.rsplit("}", 1)[-1].removeprefix("drake:")


def _validate_sizes(file: Path, element: ET.Element) -> None:
    tag = _tag(element)
    if tag == "mass":
        mass = element.get("value", element.text)
        if mass is not None and not number_in(file, tag, mass) >= 0:
            raise invalid(file, f"mass {mass} must not be negative", element=tag)
    for size in (*_POSITIVE.get(tag, ()), *_BOUNDED.get(tag, ())):
        child = element.find(size)
        text = element.get(size) or (child.text if child is not None else None)
        for word in (text or "").split():
            number = number_in(file, tag, word)
            if tag in _POSITIVE and not number > 0:
                reason = f"{tag} {size} must be positive, got {text!r}"
                raise invalid(file, reason, element=tag)
            if abs(number) > _MAX_SIZE:
                reason = f"{tag} {size} must be at most {_MAX_SIZE:g}, got {text!r}"
                raise invalid(file, reason, element=tag)


def _limits(root: ET.Element) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield the name of every joint with the words of its limits."""
    defaults = MjcfDefaults(root) if root.tag == "mujoco" else None
    for joint in root.iter("joint"):
        name = f"joint {joint.get('name', '')!r}"
        if defaults is not None:
            words = defaults.get(joint, "range").split()
            if len(words) == 2 and defaults.get(joint, "limited") != "false":
                yield name, {"lower": words[0], "upper": words[1]}
        elif root.tag == "robot":
            for limit in joint.findall("limit"):
                yield name, dict(limit.attrib)
        else:
            for limit in joint.iterfind(".//limit"):
                words_of = {child.tag: (child.text or "").strip() for child in limit}
                stated = {key: words_of[key] for key in _SDF_KEYS if words_of.get(key)}
                if stated.get("velocity", "").startswith("-"):  # that is no limit in SDF
                    del stated["velocity"]
                yield name, stated


def _validate_limit(file: Path, joint: str, limit: dict[str, str]) -> None:
    known = {
        key: _bound(file, f"{joint}: limit {key}", limit[key])
        for key in ("lower", "upper", "velocity", "effort")
        if key in limit
    }
    if known.get("lower", -math.inf) > known.get("upper", math.inf):
        reason = f"{joint}: limit lower {limit['lower']} is above upper {limit['upper']}"
        raise invalid(file, reason, element=joint)
    for key in ("velocity", "effort"):
        bound = known.get(key, 0.0)
        if bound < 0:
            reason = f"{joint}: limit {key} {limit[key]} must not be negative"
            raise invalid(file, reason, element=joint)
        if 0 < bound < _MIN_LIMIT:
            reason = f"{joint}: limit {key} {limit[key]} must be at least {_MIN_LIMIT:g}, or 0 for "
            raise invalid(file, reason + "none", element=joint)


def _bound(file: Path, what: str, word: str) -> float:
    """Return a bound, which may be infinite."""
    unbounded = word.strip().lower().lstrip("+-") in ("inf", "infinity")
    return float(word) if unbounded else number_in(file, what, word)
