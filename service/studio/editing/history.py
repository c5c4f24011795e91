"""Edits of a scene, and what takes each of them back."""

from collections.abc import Mapping
from typing import Any

type Operation = dict[str, Any]
type Document = Mapping[str, Any]

SHAPES: dict[str, Any] = {
    "box": {"box": [0.1, 0.1, 0.1]},
    "sphere": {"sphere": 0.05},
    "cylinder": {"cylinder": {"radius": 0.05, "length": 0.15}},
}


def object_of(document: Document, name: str) -> dict[str, Any]:
    """Return an object of a scene by its name."""
    return next(entry for entry in document["objects"] if entry["name"] == name)


def new_object(
    document: Document, kind: str, position: list[float], shape: Any = None
) -> dict[str, Any]:
    """Return an object that can be added, under a name that is free.

    Args:
        document: Of the scene.
        kind: One of `SHAPES`, or what a shape is to be called.
        position: p_WO [m].
        shape: As the API wants it; None for that of the kind.
    """
    taken = {entry["name"] for entry in (*document["objects"], *document["robots"])}
    name = next(f"{kind}_{i}" for i in range(1, len(taken) + 2) if f"{kind}_{i}" not in taken)
    return {
        "name": name,
        "shape": SHAPES[kind] if shape is None else shape,
        "pose": {"position": position},
        "movable": True,
        "color": [0.42, 0.56, 0.72],
    }


def replacement(document: Document, name: str, changed: Mapping[str, Any]) -> list[Operation]:
    """Return operations that put a changed object in place of one, allowed pairs as they were.

    Args:
        document: Of the scene.
        name: Of the object.
        changed: The object as it shall be, under its name or another one.

    Raises:
        ValueError: Frames hang on it, which would be lost, or pairs have margins of their own.
    """
    if lost := _lost_with(document, name):
        message = f"{', '.join(lost)} would be lost with {name}: change it in the file"
        raise ValueError(message)
    return [
        {"op": "remove", "object": name},
        {"op": "add", "object": dict(changed)},
        *_allowed_again(document, name, changed["name"]),
    ]


def inverse(document: Document, operations: list[Operation]) -> list[Operation]:
    """Return operations that take others back.

    Frames that hung on a removed object do not come back.

    Args:
        document: Of the scene before them.
        operations: To be taken back, each of an object that no other one of them concerns, but
            for one that is added in place of another.
    """
    found = list[Operation]()
    for operation in reversed(operations):
        if operation["op"] == "add":
            found.append({"op": "remove", "object": operation["object"]["name"]})
        elif operation["op"] == "remove":
            gone = object_of(document, operation["object"])
            found += [{"op": "add", "object": gone}, *_allowed_again(document, gone["name"])]
        elif operation["op"] == "move":
            pose = object_of(document, operation["object"])["pose"]
            found.append({**operation, "pose": pose})
    return found


def _lost_with(document: Document, name: str) -> list[str]:
    frames = [frame["name"] for frame in document.get("frames", []) if frame["parent"] == name]
    margins = [entry for entry in document.get("margins", []) if name in entry.get("pair", [])]
    return frames + ["a margin"] * bool(margins)


def _allowed_again(document: Document, name: str, now: str | None = None) -> list[Operation]:
    pairs = document.get("allowed_collisions", [])
    kept = [
        [now or part if part == name else part for part in pair] for pair in pairs if name in pair
    ]
    return [{"op": "allow", "pair": pair} for pair in kept]
