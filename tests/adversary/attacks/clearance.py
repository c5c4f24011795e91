"""Attack on clearance: random and grazing motions, with margins near the distance that there is.

Obstacles are pushed until the first motion passes them by a chosen distance; the other motions are
asked about with a margin near the distance that they truly keep.
"""

from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

import planning
from tests.adversary.cases import Document, Outcome, Setting
from tests.adversary.draws.motions import random_motion
from tests.adversary.draws.obstacles import random_obstacle
from tests.adversary.draws.other_robots import random_other_robots
from tests.adversary.draws.robots import random_robot
from tests.adversary.draws.shapes import random_shape
from tests.adversary.judge.clearance_judge import ClearanceJudge
from tests.adversary.judge.surroundings import Look, Stage
from tests.adversary.judge.unchecked_pairs import adjacent

# Margins that a scene may state are no larger, by far [m].
_MOST = 8.0


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a case: a robot among obstacles, and motions of it."""
    for _ in range(6):
        case = _robot_alone(rng)
        stage = Stage.of(Setting.lay_out(case, folder))
        first = free_motion(rng, stage)
        if first is not None:
            break
    motion = first or random_motion(rng, stage.robot.leaders, size=stage.size)
    for i in range(int(rng.integers(1, 4))):
        thing = random_obstacle(rng, stage, motion, f"o{i}")
        case["objects"].append(thing)
        stage.add(thing)
    more = [free_motion(rng, stage) for _ in range(3)]
    motions = [motion, *(m for m in more if m is not None)]
    case["questions"] = [_question(rng, stage, m, i == 0) for i, m in enumerate(motions)]
    if rng.random() < 0.3:
        _demand(rng, stage, case)
    return case


def _robot_alone(rng: np.random.Generator) -> Document:
    robot = random_robot(rng)
    turn = rng.uniform(-3, 3, size=3) * (rng.random() < 0.5)
    base = [(robot["size"] * rng.normal(size=3)).tolist(), turn.tolist()]
    case: Document = {"kind": "clearance", "robot": robot, "base": base, "objects": []}
    if rng.random() < 0.2:
        case["objects"].append(held_thing(rng, robot))
    if rng.random() < 0.2:
        case["others"], held = random_other_robots(rng, robot["size"])
        case["objects"] += held
        case["last"] = bool(rng.random() < 0.5)
    return case


def _demand(rng: np.random.Generator, stage: Stage, case: Document) -> None:
    """Let the scene say margins: of some pairs more or less than they keep, and of all others."""
    question, found = case["questions"][0], []
    pairs = [pair for pair in combinations(stage.bodies, 2) if not stage.is_rigid(frozenset(pair))]
    every = {frozenset(pair) for pair in pairs}
    for i in rng.permutation(len(pairs))[: int(rng.integers(1, 4))]:
        pair = frozenset(pairs[i])
        seen = stage.worst(question["motion"], Look(None, every - {pair}, pair, rounds=1))
        if seen is not None and 0 < seen.distance < _MOST:
            off = float(rng.choice([-1e-1, -1e-3, 1e-4, 1e-3, 1e-1])) * stage.size
            margin = min(max(0.0, seen.distance + off), _MOST)
            found.append({"bodies": sorted(pair), "margin": margin})
    margin = min(question.pop("margin"), _MOST) * float(rng.random() < 0.4)
    case["more"] = {"margin": margin, "margins": found}


def held_thing(rng: np.random.Generator, robot: Document) -> Document:
    """Return an object that a link holds."""
    on = robot["links"][int(rng.integers(1, len(robot["links"])))]["name"]
    xyz, rpy = 0.3 * robot["size"] * rng.normal(size=3), rng.uniform(-3, 3, size=3)
    shape = random_shape(rng, 0.2 * robot["size"])
    return {"name": "held", "shape": shape, "xyz": xyz.tolist(), "rpy": rpy.tolist(), "on": on}


def free_motion(rng: np.random.Generator, stage: Stage, **wanted: Any) -> Document | None:
    """Return a motion, most often a free one."""
    must = rng.random() < 0.85
    neighbours = adjacent(stage) if rng.random() < 0.3 else frozenset()
    for reach in (1.0, 0.5, 0.2):
        how = {"size": stage.size, "reach": reach, **wanted}
        motion = random_motion(rng, stage.robot.leaders, **how)
        look = Look(skip=neighbours, count=40, rounds=0)
        seen = stage.worst(motion, look)
        if not must or seen is None or seen.spare > 0:
            return motion
    return None


def _question(rng: np.random.Generator, stage: Stage, motion: Document, *grazed: bool) -> Document:
    question: Document = {"motion": motion, "robustness": bool(rng.random() < 0.2), "margin": 0.0}
    seen = stage.worst(motion, Look(margin=1e9))
    if seen is not None and seen.distance > 0 and not (any(grazed) and rng.random() < 0.7):
        off = float(rng.choice([-1e-1, -1e-2, -1e-3, -1e-4, 1e-5, 1e-3])) * stage.size
        question["margin"] = max(0.0, seen.distance + off)
    return question


def judge(case: Document, folder: Path) -> Outcome:
    """Ask about every motion and hold the answers against the judge's own."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    stage = Stage.of(setting)
    for question in case["questions"]:
        wanted = planning.CertifyOptions(robustness=question.get("robustness", False))
        answer = setting.ask(question, certify_options=wanted)
        outcome.count("asked")
        if isinstance(answer, Exception):
            outcome.blame("error", f"{type(answer).__name__}: {answer}")
        else:
            ClearanceJudge(setting, stage, question, outcome).hold(*answer)
    return outcome
