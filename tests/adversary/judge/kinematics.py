"""Where the links of a robot are: read from the text of its URDF, by URDF's own definitions.

A joint's value is a number; of a planar joint x, y and yaw, of a floating one a quaternion w, x, y,
z and a position. Everything takes n configurations at once.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from planning.domain.arrays import Array
from tests.adversary.draws.shapes import Shape, obj_points


@dataclass(frozen=True)
class FileJoint:
    """A joint as the file has it; a follower has a `leader`."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Array
    axis: Array
    lower: float
    upper: float
    velocity: float
    effort: float
    leader: str = ""
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Inertia:
    """Mass, centre of mass in the link's frame, rotational inertia about it in that frame."""

    mass: float
    center: Array
    matrix: Array


@dataclass(frozen=True)
class Robot:
    """What a file says: joints parents first, shapes with X_LG and inertias by link."""

    root: str
    joints: tuple[FileJoint, ...]
    shapes: dict[str, list[tuple[Shape, Array]]]
    inertias: dict[str, Inertia]

    @cached_property
    def by_name(self) -> dict[str, FileJoint]:
        return {joint.name: joint for joint in self.joints}

    @property
    def leaders(self) -> tuple[FileJoint, ...]:
        """The joints that move by themselves."""
        return tuple(j for j in self.joints if j.kind != "fixed" and not j.leader)

    def value(self, name: str, q: Mapping[str, Array]) -> Array:
        """Return the value of a joint, through all that it follows."""
        joint = self.by_name[name]
        if not joint.leader:
            return q[name]
        return joint.multiplier * self.value(joint.leader, q) + joint.offset

    def factor(self, name: str) -> tuple[str, float]:
        """Return the joint that a joint follows in the end, and how much quicker it is."""
        joint = self.by_name[name]
        if not joint.leader:
            return name, 1.0
        leader, factor = self.factor(joint.leader)
        return leader, joint.multiplier * factor

    def place(self, q: Mapping[str, Array], base: Array, count: int) -> dict[str, Array]:
        """Return X_WL of every link, shape (count, 4, 4)."""
        placed = {self.root: np.broadcast_to(base, (count, 4, 4))}
        for joint in self.joints:
            here = placed[joint.parent] @ joint.origin
            if joint.kind != "fixed":
                here = here @ motion(joint, self.value(joint.name, q), count)
            placed[joint.child] = here
        return placed

    def rigid_with(self, link: str) -> str:
        """Return the topmost link that a link is rigidly part of."""
        for joint in self.joints:
            if joint.child == link and joint.kind == "fixed":
                return self.rigid_with(joint.parent)
        return link


def motion(joint: FileJoint, value: Array, count: int) -> Array:
    """Return the pose across a joint, shape (count, 4, 4)."""
    pose = np.tile(np.eye(4), (count, 1, 1))
    match joint.kind:
        case "prismatic":
            pose[:, :3, 3] = value.reshape(-1, 1) * joint.axis
        case "planar":
            pose[:, :3, :3] = turned(joint.axis, value[:, 2])
            pose[:, :2, 3] = value[:, :2]
        case "floating":
            pose[:, :3, :3] = of_quaternion(value[:, :4])
            pose[:, :3, 3] = value[:, 4:]
        case _:
            pose[:, :3, :3] = turned(joint.axis, value.reshape(-1))
    return pose


def turned(axis: Array, angles: Array) -> Array:
    """Return rotations about one axis, by Rodrigues' formula, shape (n, 3, 3)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    sine, cosine = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.eye(3) + sine * cross + (1 - cosine) * (cross @ cross)


def of_quaternion(q: Array) -> Array:
    """Return rotations of quaternions w, x, y, z, shape (n, 4) to (n, 3, 3)."""
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def pose_matrix(xyz: Any, rpy: Any = (0, 0, 0)) -> Array:
    """Return the pose of `xyz` and fixed-axis `rpy`, shape (4, 4)."""
    pose = np.eye(4)
    axes = np.eye(3)
    roll, pitch, yaw = (turned(axes[i], np.array([float(rpy[i])]))[0] for i in range(3))
    pose[:3, :3] = yaw @ pitch @ roll
    pose[:3, 3] = xyz
    return pose


def read_robot(file: Path) -> Robot:
    """Return what a URDF says."""
    root = ET.parse(file).getroot()
    joints = [_joint(element) for element in root.findall("joint")]
    shapes: dict[str, list[tuple[Shape, Array]]] = {}
    inertias: dict[str, Inertia] = {}
    for link in root.findall("link"):
        name = link.get("name", "")
        found = [(_shape(file, e), _origin(e)) for e in link.findall("collision")]
        shapes[name] = found
        if link.find("inertial") is not None:
            inertias[name] = _inertia(link.find("inertial"))
    children = {joint.child for joint in joints}
    (top,) = [name for name in shapes if name not in children]
    return Robot(top, tuple(_parents_first(top, joints)), shapes, inertias)


def _parents_first(root: str, joints: list[FileJoint]) -> list[FileJoint]:
    ordered: list[FileJoint] = []
    known, rest = {root}, joints
    while rest:
        ready = [joint for joint in rest if joint.parent in known]
        ordered += ready
        known |= {joint.child for joint in ready}
        rest = [joint for joint in rest if joint.child not in known]
    return ordered


def _numbers(text: str | None, default: str) -> Array:
    return np.array((text or default).split(), dtype=np.float64)


def _origin(element: Any) -> Array:
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    return pose_matrix(_numbers(origin.get("xyz"), "0 0 0"), _numbers(origin.get("rpy"), "0 0 0"))


def _joint(element: Any) -> FileJoint:
    axis, limit, mimic = (element.find(tag) for tag in ("axis", "limit", "mimic"))
    along = _numbers(None if axis is None else axis.get("xyz"), "1 0 0")
    bounds = {} if limit is None else limit.attrib
    kind = element.get("type")
    is_free = kind in {"continuous", "planar", "floating"}
    return FileJoint(
        name=element.get("name"),
        kind=kind,
        parent=element.find("parent").get("link"),
        child=element.find("child").get("link"),
        origin=_origin(element),
        axis=along / np.linalg.norm(along),
        lower=-np.inf if is_free else float(bounds.get("lower", 0)),
        upper=np.inf if is_free else float(bounds.get("upper", 0)),
        velocity=float(bounds.get("velocity", np.inf)),
        effort=float(bounds.get("effort", np.inf)),
        leader="" if mimic is None else mimic.get("joint"),
        multiplier=1.0 if mimic is None else float(mimic.get("multiplier", 1)),
        offset=0.0 if mimic is None else float(mimic.get("offset", 0)),
    )


def _shape(file: Path, collision: Any) -> Shape:
    (element,) = collision.find("geometry")
    kind = element.tag.removeprefix("{http://drake.mit.edu}").removeprefix("drake:")
    match kind:
        case "box":
            return {"box": _numbers(element.get("size"), "").tolist()}
        case "sphere":
            return {"sphere": float(element.get("radius"))}
        case "cylinder" | "capsule":
            return {kind: {name: float(element.get(name)) for name in ("radius", "length")}}
        case "ellipsoid":
            return {"ellipsoid": [float(element.get(name)) for name in "abc"]}
        case _:
            points = obj_points((file.parent / element.get("filename")).read_text())
            scale = _numbers(element.get("scale"), "1 1 1")
            return {"convex": {"points": (points * scale).tolist()}}


def _inertia(element: Any) -> Inertia:
    pose, mass = _origin(element), float(element.find("mass").get("value"))
    xx, xy, xz, yy, yz, zz = (
        float(element.find("inertia").get(name))
        for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Inertia(mass, pose[:3, 3], pose[:3, :3] @ about @ pose[:3, :3].T)
