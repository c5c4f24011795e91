"""What a robot carries besides its links: payloads, and things that it holds and that weigh."""

from typing import Any

import numpy as np

from planning.domain.arrays import Array
from tests.adversary.judge.kinematics import Inertia, pose_matrix

type Document = dict[str, Any]

_KINDS = ("box", "sphere", "cylinder", "ellipsoid")


def random_payloads(rng: np.random.Generator, robot: Document) -> tuple[Document | None, Document]:
    """Return an object that is held and weighs something, and options with a payload; or neither.

    Args:
        rng: Random numbers.
        robot: Whose links have inertias.
    """
    size, links = robot["size"], [link["name"] for link in robot["links"][1:]]
    moved = _moved_links(robot)
    held: Document | None = None
    options: Document = {}
    if rng.random() < 0.5:
        held = _held(rng, size, str(rng.choice(links)))
    if rng.random() < 0.5 and moved:
        points = 0.1 * size * rng.normal(size=(5, 3))
        mass = float(10 ** rng.uniform(-1, 1))
        square = points.T @ points / 5 * mass * float(rng.random() < 0.7)
        about = np.trace(square) * np.eye(3) - square
        moments = [about[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        options["payload"] = {
            "frame": "r::" + str(rng.choice(moved)),
            "mass": mass,
            "center_of_mass": (0.3 * size * rng.normal(size=3)).tolist(),
            "inertia": [float(x) for x in moments],
        }
    return held, options


def _moved_links(robot: Document) -> list[str]:
    """Return the links that a joint moves: a payload elsewhere is refused."""
    moved: list[str] = []
    for joint in robot["joints"]:  # parents first
        if joint["type"] != "fixed" or joint["parent"] in moved:
            moved.append(joint["child"])
    return moved


def _held(rng: np.random.Generator, size: float, on: str) -> Document:
    kind, extents = str(rng.choice(_KINDS)), size * rng.uniform(0.1, 0.4, size=3)
    shapes: Document = {
        "box": extents.tolist(),
        "sphere": float(extents[0] / 2),
        "cylinder": {"radius": float(extents[0] / 2), "length": float(extents[1])},
        "ellipsoid": (extents / 2).tolist(),
    }
    weight: Document = {"mass": float(10 ** rng.uniform(-1, 1))}
    if rng.random() < 0.5:
        weight["center_of_mass"] = (0.1 * size * rng.normal(size=3)).tolist()
    return {
        "name": "held",
        "shape": {kind: shapes[kind]},
        "xyz": (0.3 * size * rng.normal(size=3)).tolist(),
        "rpy": rng.uniform(-3, 3, size=3).tolist(),
        "on": on,
        "weight": weight,
    }


def payloads_of(case: Document) -> list[tuple[str, Inertia]]:
    """Return what loads which link, in the link's frame."""
    held = [thing for thing in case.get("objects", []) if thing.get("weight")]
    found = [(str(thing["on"]), _of_held(thing)) for thing in held]
    payload = case["questions"][0]["options"].get("payload") if case.get("questions") else None
    if payload:
        xx, yy, zz, xy, xz, yz = payload["inertia"]
        about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        center = np.array(payload["center_of_mass"])
        found.append((
            payload["frame"].removeprefix("r::"),
            Inertia(payload["mass"], center, about),
        ))
    return found


def _of_held(thing: Document) -> Inertia:
    pose, mass = pose_matrix(thing["xyz"], thing["rpy"]), thing["weight"]["mass"]
    center = np.array(thing["weight"].get("center_of_mass", [0.0] * 3))
    turn = pose[:3, :3]
    about = turn @ np.diag(mass * _moments(thing["shape"])) @ turn.T
    return Inertia(mass, turn @ center + pose[:3, 3], about)


def _moments(shape: Document) -> Array:
    """Return the principal moments of a solid of uniform density and unit mass [m^2]."""
    ((kind, value),) = shape.items()
    match kind:
        case "box":
            squares = np.square(value)
            return (squares.sum() - squares) / 12
        case "sphere":
            return np.full(3, 0.4 * value**2)
        case "cylinder":
            across = (3 * value["radius"] ** 2 + value["length"] ** 2) / 12
            return np.array([across, across, value["radius"] ** 2 / 2])
        case _:
            squares = np.square(value)
            return (squares.sum() - squares) / 5
