"""The arms of the problems, their limits, and each problem as a scene for the planner."""

from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import yaml

import planning
from benchmarks.motion_bench_maker.problems import DataMissing, Obstacle, Problem

ARM = "arm"
# Acceleration of every joint where jerk is limited [rad/s^2].
_WITH_JERK = 15.0


@dataclass(frozen=True)
class RobotSpec:
    """What the benchmark decides about a robot.

    Attributes:
        name: Of its folder, URDF and SRDF.
        tool: The link whose pose is the pose goal.
        velocity: Limit per joint [rad/s].
        acceleration: Limit per joint [rad/s^2].
        jerk: Limit per joint [rad/s^3]; None for none.
    """

    name: str
    tool: str
    velocity: tuple[float, ...]
    acceleration: tuple[float, ...]
    jerk: tuple[float, ...] | None = None

    def with_jerk(self, jerk: float) -> "RobotSpec":
        """Return the robot under cuRobo's limits: 15 rad/s^2, and a jerk, for every joint."""
        count = len(self.acceleration)
        return replace(self, acceleration=(_WITH_JERK,) * count, jerk=(jerk,) * count)


ROBOTS = {
    "panda": RobotSpec(
        "panda",
        "panda_hand",
        velocity=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
        acceleration=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
    ),
    # The data's URDF says 0.5 rad/s, a tenth of what the arm can do.
    "ur5": RobotSpec("ur5", "tool0", velocity=(pi,) * 6, acceleration=(10.0,) * 6),
}


@dataclass(frozen=True)
class RobotFiles:
    """A robot as the data has it.

    Attributes:
        spec: Its limits and tool.
        urdf: Its description.
        disabled_pairs: Links that may touch, from the SRDF.
    """

    spec: RobotSpec
    urdf: Path
    disabled_pairs: tuple[tuple[str, str], ...]

    @property
    def root_link(self) -> str:
        """The link that is nobody's child."""
        root = ET.parse(self.urdf).getroot()
        children = {child.get("link") for child in root.iter("child")}
        names = [link.get("name", "") for link in root.findall("link")]
        return next(name for name in names if name not in children)


def robot_files(models: Path, spec: RobotSpec) -> RobotFiles:
    """Return a robot's files in a folder of models.

    Raises:
        DataMissing: They are not there.
    """
    urdf = models / spec.name / f"{spec.name}.urdf"
    srdf = urdf.with_suffix(".srdf")
    for file in (urdf, srdf):
        if not file.is_file():
            message = f"there is no {file}: name the folder of the models with --models DIR"
            raise DataMissing(message)
    pairs = ET.parse(srdf).getroot().iter("disable_collisions")
    return RobotFiles(
        spec, urdf, tuple((pair.get("link1", ""), pair.get("link2", "")) for pair in pairs)
    )


def robot_library(
    files: RobotFiles, joints: tuple[str, ...], folder: Path
) -> planning.ModelLibrary:
    """Write a robot.yaml beside links to the data's files, and return the library of that robot.

    Args:
        files: What to link to.
        joints: The arm's joints, in the problems' order.
        folder: An empty one, for as long as the library is used.
    """
    home = folder / f"mbm_{files.spec.name}"
    home.mkdir()
    for file in files.urdf.parent.iterdir():
        (home / file.name).symlink_to(file.resolve())
    rates = zip(files.spec.velocity, files.spec.acceleration, strict=True)
    card: dict[str, Any] = {
        "name": home.name,
        "file": files.urdf.name,
        "base": files.root_link,
        "default_group": ARM,
        "groups": {ARM: {"joints": list(joints), "tool_frames": [files.spec.tool]}},
        "limits": {
            joint: {"velocity": velocity, "acceleration": acceleration}
            for joint, (velocity, acceleration) in zip(joints, rates, strict=True)
        },
        "allowed_collisions": [list(pair) for pair in files.disabled_pairs],
    }
    for joint, jerk in zip(joints, files.spec.jerk or (), strict=False):
        card["limits"][joint]["jerk"] = jerk
    card_file = home / "robot.yaml"
    card_file.unlink(missing_ok=True)
    card_file.write_text(yaml.safe_dump(card), "utf-8")
    return planning.ModelLibrary((folder,), allow_paths=False)


def scene_of(problem: Problem, spec: RobotSpec) -> planning.Scene:
    """Return a problem as a scene, with the robot at the start."""
    start = dict(zip(problem.joints, problem.start, strict=True))
    return planning.parse_scene({
        "name": f"{problem.set}_{problem.index}",
        "robots": [{"name": "robot", "model": f"mbm_{spec.name}", "positions": start}],
        "objects": [
            {
                "name": thing.name,
                "shape": _shape(thing),
                "pose": {
                    "position": list(thing.position),
                    "quaternion": list(thing.quaternion),
                },
            }
            for thing in problem.obstacles
        ],
    })


def _shape(thing: Obstacle) -> dict[str, Any]:
    match thing.kind, thing.dims:
        case "box", (x, y, z):
            return {"box": [x, y, z]}
        case "cylinder", (length, radius):
            return {"cylinder": {"radius": radius, "length": length}}
        case "sphere", (radius,):
            return {"sphere": radius}
        case _:
            message = f"object {thing.name!r} is a {thing.kind!r} of sizes {thing.dims}"
            raise DataMissing(message)
