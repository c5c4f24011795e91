"""MJCF features that Drake's parser ignores, often without a warning."""

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

from planning.errors import AssetNotFound, ModelInvalid
from planning.world.documents.xml_file import xml_root

# Bodies and geoms inside these never reach Drake's plant.
_UNSUPPORTED_ELEMENTS = ("attach", "composite", "flex", "flexcomp", "frame", "replicate")
_UNSUPPORTED_MESH_ATTRIBUTES = {"refpos": [0.0, 0.0, 0.0], "refquat": [1.0, 0.0, 0.0, 0.0]}
_MAX_INCLUDES = 100


@dataclass(frozen=True)
class JointEquality:
    """MJCF joint equality: q_follower = multiplier * q_leader + offset."""

    follower: str
    leader: str
    multiplier: float
    offset: float


class MjcfDefaults:
    """Attributes of MJCF elements, with the defaults of their classes."""

    def __init__(self, root: ET.Element) -> None:
        """Read the `default` elements of a model."""
        self._defaults_by_class: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        self._class_of: dict[ET.Element, str] = {}
        for default in root.findall("default"):
            self._read(default, default.get("class", "main"), {})
        for child in root:
            if child.tag != "default":
                self._assign_classes(child, "main")

    def get(self, element: ET.Element, name: str, default: str = "") -> str:
        """Return an attribute of an element of the model, or its class default."""
        chosen = element.get("class") or self._class_of.get(element, "main")
        by_class = self._defaults_by_class.get(chosen, {}).get(element.tag, {})
        return element.get(name) or by_class.get(name) or default

    def _read(self, default: ET.Element, name: str, inherited: dict[str, dict[str, str]]) -> None:
        own = {tag: dict(values) for tag, values in inherited.items()}
        for element in default:
            if element.tag != "default":
                own[element.tag] = {**own.get(element.tag, {}), **element.attrib}
        self._defaults_by_class[name] = {**self._defaults_by_class.get(name, {}), **own}
        for child in default.findall("default"):
            self._read(child, child.get("class", ""), self._defaults_by_class[name])

    def _assign_classes(self, element: ET.Element, chosen: str) -> None:
        """Record the class that each element inherits from the bodies around it."""
        self._class_of[element] = chosen
        child_class = element.get("childclass") or chosen
        for child in element:
            self._assign_classes(child, child_class)


def with_includes(file: Path, root: ET.Element) -> bool:
    """Replace every `include` by the included elements; return whether there was one.

    Raises:
        AssetNotFound: An included file does not exist.
        ModelInvalid: It is not XML, or includes itself, or too many are included.
    """
    return bool(_expand(file, root, (_resolved(file, file.name),), _MAX_INCLUDES))


def _expand(file: Path, root: ET.Element, chain: tuple[Path, ...], max_includes: int) -> int:
    """Expand the includes of the last file of a chain; return their number."""
    count = 0
    for parent in [parent for parent in root.iter() if parent.find("include") is not None]:
        for include in parent.findall("include"):
            name = include.get("file", "")
            path = _resolved(file, name)
            if path in chain:
                cycle = " -> ".join(step.name for step in (*chain[chain.index(path) :], path))
                raise _invalid(file, f"it includes itself: {cycle}")
            inner = _included(file, name)
            count += 1 + _expand(file, inner, (*chain, path), max_includes - count - 1)
            if count > max_includes:
                raise _invalid(file, f"more than {_MAX_INCLUDES} files are included")
            index = list(parent).index(include)
            parent[index : index + 1] = list(inner)
    return count


def _resolved(file: Path, name: str) -> Path:
    return Path(os.path.normpath(file.parent / name))


def _included(file: Path, name: str) -> ET.Element:
    path = file.parent / name
    if not path.is_file():
        message = f"{file.name} includes {name!r}, which is not at {path}"
        raise AssetNotFound(message, {"uri": name, "known": []})
    try:
        return xml_root(path.read_bytes())
    except ValueError as fault:
        raise _invalid(file, f"the included {name!r} cannot be read: {fault}") from fault


def validate_supported_elements(file: Path, root: ET.Element) -> None:
    """Raise if Drake's parser ignores a part of a model that moves or collides.

    Raises:
        ModelInvalid: It would leave out bodies or geoms, or move a mesh.
    """
    for element in (inner for part in ("worldbody", "deformable") for inner in root.iter(part)):
        for inner in element.iter():
            if inner.tag in _UNSUPPORTED_ELEMENTS:
                reason = f"<{inner.tag}> is not read: write out the bodies and geoms that it makes"
                raise _invalid(file, reason)
    _validate_sphere_radii(file, root)
    for mesh in root.iter("mesh"):
        for attribute, default in _UNSUPPORTED_MESH_ATTRIBUTES.items():
            numbers = [_number(file, word) for word in mesh.get(attribute, "").split()]
            if numbers not in ([], default):
                reason = f"mesh {mesh.get('name') or mesh.get('file')!r} has {attribute!r}, which "
                raise _invalid(file, reason + "is not read: move the mesh's vertices instead")


def _validate_sphere_radii(file: Path, root: ET.Element) -> None:
    """Raise unless every sphere has a radius: without one Drake makes a point."""
    defaults = MjcfDefaults(root)
    for geom in (geom for world in root.findall("worldbody") for geom in world.iter("geom")):
        radius = [_number(file, word) for word in defaults.get(geom, "size").split()][:1]
        kind = defaults.get(geom, "type", "sphere")
        if kind == "sphere" and not defaults.get(geom, "mesh") and radius in ([], [0.0]):
            raise _invalid(file, f"geom {geom.get('name', '')!r} is a sphere without a radius")


def joint_equalities(file: Path, root: ET.Element) -> list[JointEquality]:
    """Return the joints that follow others by an `equality`.

    MuJoCo's constraint is y - y0 = a0 + a1 (x - x0) + a2 (x - x0)^2 + ..., with x0 and y0 the
    joints' `ref` (MuJoCo's XML reference, equality/joint); coefficients of angles are in radians.

    Raises:
        ModelInvalid: An active equality is of another kind, or of a degree other than 1.
    """
    defaults = MjcfDefaults(root)
    joints = {
        joint.get("name", ""): joint
        for body in root.iter("body")
        for joint in body.findall("joint")
        if joint.get("name")
    }
    compiler = [c.get("angle", "") for c in root.iter("compiler") if c.get("angle")]
    degrees = (compiler or ["degree"])[-1] == "degree"

    def ref(name: str) -> float:
        joint = joints[name]
        value = _number(file, defaults.get(joint, "ref", "0"))
        is_angle = defaults.get(joint, "type", "hinge") == "hinge"
        return math.radians(value) if is_angle and degrees else value

    found: list[JointEquality] = []
    for equality in _active_equalities(root, defaults):
        names = (equality.get("joint1", ""), equality.get("joint2", ""))
        kind = f"equality <{equality.tag}> {equality.get('name', '')!r}".removesuffix(" ''")
        if equality.tag != "joint":
            raise _invalid(file, f"{kind} is not supported: only equalities of two joints are")
        if any(name not in joints for name in names):
            raise _invalid(file, f"{kind} joins {list(names)}, which are not both joints of it")
        if names[0] in (other.follower for other in found):
            raise _invalid(
                file, f"{kind}: joint {names[0]!r} already follows another joint by an equality"
            )
        words = defaults.get(equality, "polycoef", "0 1 0 0 0").split()
        a = [*(_number(file, word) for word in words), *[0.0] * 5]
        if a[1] == 0 or any(a[2:]):
            raise _invalid(
                file, f"{kind} of {list(names)} is a polynomial of a degree other than 1"
            )
        offset = ref(names[0]) + a[0] - a[1] * ref(names[1])
        found.append(JointEquality(names[0], names[1], a[1], offset))
    return found


def _active_equalities(root: ET.Element, defaults: MjcfDefaults) -> Iterator[ET.Element]:
    for section in root.findall("equality"):
        for equality in section:
            active = equality.get("active") or defaults.get(ET.Element("equality"), "active")
            if active != "false":
                yield equality


def _number(file: Path, word: str) -> float:
    try:
        number = float(word)
    except ValueError as fault:
        raise _invalid(file, f"a number is required, got {word!r}") from fault
    if not math.isfinite(number):
        raise _invalid(file, f"a finite number is required, got {word!r}")
    return number


def _invalid(file: Path, reason: str) -> ModelInvalid:
    return ModelInvalid(f"{file.name}: {reason}", {"file": str(file), "reason": reason})
