"""Robots that stand beside the one that moves: where their links are, and what they hold."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from tests.adversary.draws.robots import SCALARS, random_robot
from tests.adversary.draws.shapes import random_shape
from tests.adversary.judge.kinematics import Robot, pose_matrix, read_robot

type Document = dict[str, Any]


@dataclass(frozen=True)
class Standing:
    """A robot that stands, with X_WL of its links, each of shape (4, 4)."""

    name: str
    robot: Robot
    placed: dict[str, Array]

    def cluster(self, link: str) -> str:
        """Return what a link is rigidly part of; the root's is "", the world's."""
        top = self.robot.rigid_with(link)
        return "" if top == self.robot.root else f"{self.name}::{top}"

    def things(self) -> list[Document]:
        """Return the shapes of its links as things that stand."""
        return [
            {
                "name": f"{self.name}::{link}",
                "shape": shape,
                "pose": self.placed[link] @ pose,
                "cluster": self.cluster(link),
            }
            for link, shapes in self.robot.shapes.items()
            for shape, pose in shapes
        ]

    def held(self, thing: Document) -> Document:
        """Return what it holds as a thing that stands."""
        pose = self.placed[thing["on"]] @ pose_matrix(thing["xyz"], thing["rpy"])
        return {**thing, "pose": pose, "cluster": self.cluster(thing["on"])}


def read_other_robots(case: Document, folder: Path) -> dict[str, Standing]:
    """Return the robots that stand, by name, from their files and positions."""
    found: dict[str, Standing] = {}
    for other in case.get("others", []):
        robot = read_robot(folder / other["name"] / "robot.urdf")
        q = {name: np.array([[value]]) for name, value in other["positions"].items()}
        placed = robot.place(q, pose_matrix(*other["base"]), 1)
        still = {link: pose[0] for link, pose in placed.items()}
        found[other["name"]] = Standing(other["name"], robot, still)
    return found


def random_other_robots(
    rng: np.random.Generator, size: float
) -> tuple[list[Document], list[Document]]:
    """Return one or two robots that stand near the origin, and what they hold."""
    others: list[Document] = []
    held: list[Document] = []
    for i in range(int(rng.integers(1, 3))):
        robot = random_robot(
            rng, kinds=(*SCALARS, "fixed"), size=size, links=int(rng.integers(1, 4))
        )
        turn = rng.uniform(-3, 3, size=3) * (rng.random() < 0.5)
        others.append({
            "name": f"s{i}",
            "robot": robot,
            "base": [(1.5 * size * rng.normal(size=3)).tolist(), turn.tolist()],
            "positions": {
                joint["name"]: _within(rng, joint)
                for joint in robot["joints"]
                if joint["type"] in SCALARS and "mimic" not in joint
            },
        })
        if rng.random() < 0.4:
            held.append(_held_by(rng, others[-1], size))
    return others, held


def _within(rng: np.random.Generator, joint: Document) -> float:
    middle, half = (joint["upper"] + joint["lower"]) / 2, (joint["upper"] - joint["lower"]) / 2
    return float(middle + 0.8 * half * rng.uniform(-1, 1))


def _held_by(rng: np.random.Generator, other: Document, size: float) -> Document:
    on = other["robot"]["links"][-1]["name"]
    place, turn = 0.3 * size * rng.normal(size=3), rng.uniform(-3, 3, size=3)
    return {
        "name": f"held_by_{other['name']}",
        "shape": random_shape(rng, 0.2 * size),
        "xyz": place.tolist(),
        "rpy": turn.tolist(),
        "on": on,
        "robot": other["name"],
    }
