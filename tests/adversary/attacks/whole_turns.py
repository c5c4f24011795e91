"""Attack on whole turns: what follows a joint by a half is not where it was a turn later.

Two things are asked. Where pieces meet, and at start and goal, every link must be where it was, by
the robot's file. And what samples say, taken as numbers, is what must be free.
"""

import time
from pathlib import Path
from typing import Any

import numpy as np

import planning
from planning.errors import WayproofError
from tests.adversary.cases import PATIENCE, Document, Outcome, Setting
from tests.adversary.draws.motions import around, hermite, positions
from tests.adversary.draws.robots import random_robot
from tests.adversary.judge.kinematics import Robot
from tests.adversary.judge.surroundings import Look, Stage

_SAME = 1e-4


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a motion in pieces anchored turns apart, or far samples, with a post in the way."""
    kinds = ("continuous", "continuous", "revolute")
    robot = random_robot(rng, kinds=kinds, mimics=0.6, size=1.0, shapes=("box", "sphere"))
    for joint in robot["joints"]:
        if "mimic" in joint:
            joint["mimic"] = {
                **joint["mimic"],
                "multiplier": float(rng.choice([0.5, -1.5, 2.0, 1 / 3, 1.0])),
            }
            joint.update(type="continuous")
    case: Document = {"kind": "whole_turns", "robot": robot, "objects": []}
    read = Setting.lay_out(case, folder).robot
    rows = 2 if rng.random() < 0.5 else 3
    places = {
        j.name: rng.uniform(-0.4, 0.4, size=rows) * (8 if j.kind == "continuous" else 1)
        for j in read.leaders
    }
    for joint in read.leaders:
        if joint.kind != "continuous":
            places[joint.name] = np.clip(places[joint.name], joint.lower * 0.9, joint.upper * 0.9)
    question: Document = {
        "samples": {name: row.tolist() for name, row in places.items()},
        "turns": {j.name: _turns(rng, j.kind, rows) for j in read.leaders},
        "by_samples": bool(rng.random() < 0.5),
        "ends": {
            j.name: [int(x) for x in rng.integers(-1, 2, size=2)]
            for j in read.leaders
            if j.kind == "continuous"
        },
    }
    case["questions"] = [question]
    if question["by_samples"]:
        case["objects"] = _in_the_way(rng, Stage(read, case, np.eye(4), {}), meant(question))
    return case


def _in_the_way(rng: np.random.Generator, stage: Stage, motion: Document) -> list[Document]:
    """Return a ball where something is on the way that the numbers say, if anything moves."""
    pieces, local, _ = around(motion, rng.uniform(0.2, 0.8) * motion["breaks"][-1], 0.0, 1)
    solids = stage.solids(positions(motion, pieces, local), 1)
    moved = [solid for solid in solids if stage.is_moved(solid.body)]
    if not moved:
        return []
    place = moved[int(rng.integers(len(moved)))].middles[0]
    ball = {"name": "ball", "shape": {"sphere": 0.02}, "rpy": [0.0] * 3}
    return [{**ball, "xyz": [float(x) for x in place]}]


def _turns(rng: np.random.Generator, kind: str, rows: int) -> list[int]:
    if kind != "continuous" or rng.random() < 0.4:
        return [0] * (rows - 1)
    return [0, *(int(x) for x in rng.integers(-1, 2, size=rows - 2))]


def meant(question: Document) -> Document:
    """Return the motion that the numbers say, from sample to sample, at rest at each."""
    parts: Document = {}
    for name, row in question["samples"].items():
        zero = np.zeros((2, 1))
        steps = np.diff(row)
        pieces = [hermite(4.0, np.array([step]), zero, zero, 3).tolist() for step in steps]
        parts[name] = {"bases": [[x] for x in row[:-1]], "coefficients": pieces}
    rows = len(next(iter(question["samples"].values())))
    return {"breaks": [4.0 * i for i in range(rows)], "joints": parts}


def anchored(question: Document) -> Document:
    """Return the same with some pieces anchored whole turns away."""
    motion = meant(question)
    for name, turns in question["turns"].items():
        part = motion["joints"][name]
        pairs = zip(part["bases"], turns, strict=True)
        part["bases"] = [[base[0] + 2 * np.pi * turn] for base, turn in pairs]
    return motion


def judge(case: Document, folder: Path) -> Outcome:
    """Ask, and see whether links jump and whether the numbers' own motion is free."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    for question in case["questions"]:
        outcome.count("asked")
        if question["by_samples"]:
            _by_samples(setting, question, outcome)
        else:
            _by_pieces(setting, question, outcome)
    return outcome


def _by_pieces(setting: Setting, question: Document, outcome: Outcome) -> None:
    motion = anchored(question)
    names = [joint.name.removeprefix("r::") for joint in setting.group.joints]
    first = {name: positions(motion, np.array([0]), np.array([0.0]))[name][0] for name in names}
    ends = question["ends"]
    start = np.array([first[n][0] + 2 * np.pi * ends.get(n, [0, 0])[0] for n in names])
    answer = setting.ask({"motion": motion}, start=start)
    if isinstance(answer, Exception) or not answer[0].proven:
        return
    outcome.count("proven")
    robot, base = setting.robot, setting.base
    sides = [(b, 0.0) for b in range(1, len(motion["breaks"]) - 1)]
    for piece, _ in sides:
        width = motion["breaks"][piece] - motion["breaks"][piece - 1]
        places = [(piece - 1, width), (piece, 0.0)]
        gap = _apart(
            robot, base, [positions(motion, np.array([p]), np.array([t])) for p, t in places]
        )
        if gap > _SAME:
            outcome.blame(
                "links jump", f"{gap:.4g} m where pieces meet, at {motion['breaks'][piece]} s", 5
            )
    asked = {name: np.array([[x]]) for name, x in zip(names, start, strict=True)}
    gap = _apart(robot, base, [asked, positions(motion, np.array([0]), np.array([0.0]))])
    if gap > _SAME:
        outcome.blame("links jump", f"{gap:.4g} m from the start that was asked for", 5)


def _apart(robot: Robot, base: Any, sides: list[Any]) -> float:
    """Return how far points of a metre about a link are apart in two configurations [m]."""
    placed = [robot.place(q, base, 1) for q in sides]
    return max(float(np.abs(placed[0][link] - placed[1][link]).max()) for link in placed[0])


def _by_samples(setting: Setting, question: Document, outcome: Outcome) -> None:
    motion = meant(question)
    joints = setting.group.joints
    names = [joint.name.removeprefix("r::") for joint in joints]
    rows = np.array([question["samples"][name] for name in names]).T
    deadline = planning.Deadline.after(PATIENCE, time.process_time)
    try:
        curve = planning.trajectory_through(
            joints, np.array(motion["breaks"]), rows, np.zeros_like(rows)
        )
        certificate, _ = planning.certify_trajectory(
            setting.world, "r", curve, deadline=deadline, goal=rows[-1]
        )
    except WayproofError as fault:
        outcome.count(f"answered by {type(fault).__name__}")
        return
    if not certificate.proven:
        return
    outcome.count("proven")
    seen = Stage.of(setting).worst(motion, Look(rounds=1, skip=_neighbours(setting.robot)))
    if seen is not None and seen.distance < -1e-5:
        said = f"{seen.near.pair} {seen.distance:.4g} m apart at {seen.time:.4g} s"
        outcome.blame("samples the short way", f"samples {question['samples']}: {said}", 5)
    gap = _apart(
        setting.robot,
        setting.base,
        [
            positions(motion, np.array([len(rows) - 2]), np.array([4.0])),
            {name: curve.end[None, [i]] for i, name in enumerate(names)},
        ],
    )
    if gap > _SAME:
        outcome.blame("samples the short way", f"ends {gap:.4g} m from the last sample", 5)


def _neighbours(robot: Robot) -> frozenset[frozenset[str]]:
    return frozenset(frozenset((f"r::{j.parent}", f"r::{j.child}")) for j in robot.joints)
