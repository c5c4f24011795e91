"""Cut a failing case down: leave out what it fails without, and round what is left."""

import copy
from collections.abc import Callable, Iterator
from typing import Any

from tests.adversary.cases import Document

# Cases that are tried at most.
_MOST = 300


def shrunk(case: Document, fails: Callable[[Document], bool], most: int = _MOST) -> Document:
    """Return a case that still fails, of which nothing can be left out.

    Args:
        case: One that fails.
        fails: Whether a case does; one that cannot be judged does not.
        most: Cases to try.
    """
    tried = 0
    is_smaller = True
    while is_smaller:
        is_smaller = False
        for candidate in _smaller(case):
            tried += 1
            if tried > most:
                return case
            if fails(candidate):
                case, is_smaller = candidate, True
                break
    return case


def _smaller(case: Document) -> Iterator[Document]:
    """Yield cases with a little less in them, what saves most first."""
    for make in (
        _questions,
        _objects,
        _others,
        _demands,
        _links,
        _shapes,
        _pieces,
        _plain,
        _rounded,
    ):
        yield from make(case)


def _changed(case: Document) -> Document:
    return copy.deepcopy(case)


def _questions(case: Document) -> Iterator[Document]:
    count = len(case.get("questions", []))
    for i in range(count if count > 1 else 0):
        yield {**case, "questions": [case["questions"][i]]}


def _objects(case: Document) -> Iterator[Document]:
    for i in range(len(case.get("objects", []))):
        made = _changed(case)
        del made["objects"][i]
        yield made


def _others(case: Document) -> Iterator[Document]:
    """Leave out a robot that stands, with what it holds."""
    for other in case.get("others", []):
        made = _changed(case)
        made["others"] = [entry for entry in made["others"] if entry["name"] != other["name"]]
        made["objects"] = [t for t in made["objects"] if t.get("robot", "r") != other["name"]]
        yield made


def _demands(case: Document) -> Iterator[Document]:
    """Leave out a margin of a pair."""
    for i in range(len(case.get("more", {}).get("margins", []))):
        made = _changed(case)
        del made["more"]["margins"][i]
        yield made


def _links(case: Document) -> Iterator[Document]:
    """Leave out a link that carries nothing, with its joint and all that is said of it."""
    joints = case.get("robot", {}).get("joints", [])
    parents = {joint["parent"] for joint in joints}
    leaders = {joint["mimic"]["joint"] for joint in joints if "mimic" in joint}
    holding = {thing.get("on") for thing in case.get("objects", [])}
    for joint in joints:
        if joint["child"] in parents | holding or joint["name"] in leaders or len(joints) == 1:
            continue
        made = _changed(case)
        robot = made["robot"]
        robot["joints"] = [other for other in robot["joints"] if other["name"] != joint["name"]]
        robot["links"] = [link for link in robot["links"] if link["name"] != joint["child"]]
        _forget(made, joint["name"])
        yield made


def _forget(node: Any, name: str) -> None:
    """Drop a joint from every table and list of names."""
    if isinstance(node, dict):
        node.pop(name, None)
        for part in node.values():
            _forget(part, name)
    elif isinstance(node, list):
        if name in node:
            node.remove(name)
        for part in node:
            if isinstance(part, dict | list):
                _forget(part, name)


def _shapes(case: Document) -> Iterator[Document]:
    for i, link in enumerate(case.get("robot", {}).get("links", [])):
        for k in range(len(link["shapes"])):
            made = _changed(case)
            del made["robot"]["links"][i]["shapes"][k]
            yield made


def _pieces(case: Document) -> Iterator[Document]:
    """Keep the first or the second half of a motion's pieces."""
    for i, question in enumerate(case.get("questions", [])):
        count = len(question.get("motion", {}).get("breaks", [0])) - 1
        for begin, end in ((0, count // 2), (count // 2, count)) if count > 1 else ():
            made = _changed(case)
            motion = made["questions"][i]["motion"]
            first = motion["breaks"][begin]
            motion["breaks"] = [time - first for time in motion["breaks"][begin : end + 1]]
            for part in motion["joints"].values():
                part["bases"] = part["bases"][begin:end]
                part["coefficients"] = part["coefficients"][begin:end]
            yield made


def _plain(case: Document) -> Iterator[Document]:
    """Put the base, and then each frame, at the origin without a turn."""
    if any(map(any, case.get("base", []))):
        yield {**case, "base": [[0.0] * 3, [0.0] * 3]}
    for i, joint in enumerate(case.get("robot", {}).get("joints", [])):
        for field in ("xyz", "rpy"):
            if any(joint[field]):
                made = _changed(case)
                made["robot"]["joints"][i][field] = [0.0] * 3
                yield made


def _rounded(case: Document) -> Iterator[Document]:
    """Keep three digits of the numbers of the robot and the objects."""
    made = {**case}
    for field in ("robot", "objects", "base"):
        if field in case:
            made[field] = _round(case[field])
    if made != case:
        yield made


def _round(node: Any) -> Any:
    if isinstance(node, dict):
        return {name: _round(part) for name, part in node.items()}
    if isinstance(node, list):
        return [_round(part) for part in node]
    return float(f"{node:.3g}") if isinstance(node, float) else node
