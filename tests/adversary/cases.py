"""An attack as a document, and the same loaded: files on disk, a world, and the judge's robot.

A case is JSON: `robot` (`draws/robots.py`), `base`, `objects`, `card` (a robot.yaml) or None, and
`questions`, each with a `motion` and what it is held against. `kind` says who judges it. `others`
are robots that stand beside it (`draws/other_robots.py`), and `more` is the rest of the scene's
document.
"""

import json
import time
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import planning
from planning.domain.arrays import Array
from planning.errors import WayproofError
from tests.adversary.draws.robots import urdf_files
from tests.adversary.draws.shapes import obj_text
from tests.adversary.judge.kinematics import Robot, pose_matrix, read_robot

type Document = dict[str, Any]

# More time of the processor no question may take [s].
PATIENCE = 30.0


@dataclass(frozen=True)
class Claim:
    """Something that was said and is not so.

    Attributes:
        what: Which property, one or two words.
        said: What was said, and what is.
        issue: The number of the defect that this is, as far as it is known; 0 for a new one.
    """

    what: str
    said: str
    issue: int = 0


@dataclass
class Outcome:
    """What became of a case.

    Attributes:
        wrong: Everything that was said and is not so.
        refused: What was kept by far and not proven: that is no lie, but is told.
        counts: How many questions were asked, proven, refused though there was room, and so on.
    """

    wrong: list[Claim] = field(default_factory=list)
    refused: list[Claim] = field(default_factory=list)
    counts: dict[str, float] = field(default_factory=dict)

    def count(self, what: str, by: float = 1) -> None:
        self.counts[what] = self.counts.get(what, 0) + by

    def blame(self, what: str, said: str, issue: int = 0) -> None:
        self.wrong.append(Claim(what, said, issue))

    def refuse(self, what: str, said: str, issue: int = 0) -> None:
        self.refused.append(Claim(f"{what} refused", said, issue))

    def add(self, other: "Outcome") -> None:
        self.wrong += other.wrong
        self.refused += other.refused
        for name, number in other.counts.items():
            keep = max if name.startswith("longest") else sum
            self.counts[name] = keep([self.counts.get(name, 0), number])


@dataclass(frozen=True)
class Setting:
    """A case on disk."""

    case: Document
    folder: Path

    @classmethod
    def lay_out(cls, case: Document, folder: Path) -> "Setting":
        """Write the files of a case."""
        files = urdf_files(case["robot"])
        for thing in case.get("objects", []):
            if "convex" in thing["shape"] and thing.get("as_mesh"):
                files[f"{thing['name']}.obj"] = obj_text(
                    np.array(thing["shape"]["convex"]["points"])
                )
        if case.get("card"):
            files["robot.yaml"] = yaml.safe_dump(case["card"])
        for other in case.get("others", []):
            own = urdf_files(other["robot"])
            files |= {f"{other['name']}/{name}": text for name, text in own.items()}
        for name, text in files.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text(text)
        return cls(case, folder)

    @cached_property
    def robot(self) -> Robot:
        """What the judge reads in the file."""
        return read_robot(self.folder / "robot.urdf")

    @property
    def base(self) -> Array:
        return pose_matrix(*self.case.get("base", ([0, 0, 0], [0, 0, 0])))

    @cached_property
    def document(self) -> Document:
        """The scene, as it is posted."""
        robot: Document = {"name": "r", "model": str(self.folder / "robot.urdf")}
        xyz, rpy = self.case.get("base", ([0, 0, 0], [0, 0, 0]))
        robot["base"] = {"position": xyz, "rpy": rpy}
        if self.case.get("positions"):
            robot["positions"] = self.case["positions"]
        objects = [self._object(thing) for thing in self.case.get("objects", [])]
        others = [self._other(other) for other in self.case.get("others", [])]
        return {
            "name": "attack",
            "robots": [*others, robot] if self.case.get("last") else [robot, *others],
            "objects": objects,
            **self.case.get("more", {}),
        }

    def _other(self, other: Document) -> Document:
        xyz, rpy = other["base"]
        model = str(self.folder / other["name"] / "robot.urdf")
        pose, positions = {"position": xyz, "rpy": rpy}, other["positions"]
        return {"name": other["name"], "model": model, "base": pose, "positions": positions}

    def _object(self, thing: Document) -> Document:
        shape = thing["shape"]
        if "convex" in shape and thing.get("as_mesh"):
            shape = {"mesh": {"uri": str(self.folder / f"{thing['name']}.obj")}}
        pose = {"position": thing["xyz"], "rpy": thing["rpy"]}
        entry = {"name": thing["name"], "shape": shape, "pose": pose}
        if thing.get("on"):
            frame = f"{thing.get('robot', 'r')}::{thing['on']}"
            entry |= {"movable": True, "attached": {"frame": frame}}
        return entry | thing.get("weight", {})

    @cached_property
    def world(self) -> Any:
        """The scene, loaded by the product."""
        return planning.load_world(planning.parse_scene(self.document))

    @property
    def group(self) -> Any:
        return self.world.group("r")

    def curve(self, motion: Document) -> Any:
        """Return a motion as the product has it: columns in the order of its joints."""
        names = [joint.name.removeprefix("r::") for joint in self.group.joints]
        parts = [motion["joints"][name] for name in names]
        bases = np.concatenate([np.array(part["bases"], dtype=float) for part in parts], axis=1)
        powers = np.concatenate(
            [np.array(part["coefficients"], dtype=float) for part in parts], axis=2
        )
        breaks = np.array(motion["breaks"], dtype=float)
        return planning.TimedTrajectory(self.group.joints, breaks, bases, powers)

    def ask(self, question: Document, patience: float = PATIENCE, **more: Any) -> Any:
        """Return the certificate and report of a question, or the error that answers it."""
        deadline = planning.Deadline.after(patience, time.process_time)
        if "margin" in question:
            more["margin"] = question["margin"]
        if "options" in question:
            more["options"] = options_of(question)
        curve = self.curve(question["motion"])
        try:
            return planning.certify_trajectory(self.world, "r", curve, deadline=deadline, **more)
        except WayproofError as fault:
            return fault


def options_of(question: Document) -> Any:
    """Return the limits of a question."""
    options = dict(question.get("options", {}))
    if "payload" in options:
        options["payload"] = planning.Payload.from_parts(**options["payload"])
    if "tool_limits" in options:
        options["tool_limits"] = tuple(planning.ToolLimit(**t) for t in options["tool_limits"])
    return planning.RetimeOptions(**options)


def check_of(certificate: Any, name: str) -> Any:
    """Return a check by its name."""
    return next(check for check in certificate.checks if check.name == name)


def text_of(case: Document) -> str:
    """Return a case as text that `run --case` takes."""
    return json.dumps(case)
