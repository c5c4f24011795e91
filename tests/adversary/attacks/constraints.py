"""Attack on path constraints and limits of frames: bounds just above or below what is reached."""

import time
from pathlib import Path
from typing import Any

import numpy as np

import planning
from tests.adversary.attacks.clearance import free_motion
from tests.adversary.cases import Document, Outcome, Setting, check_of
from tests.adversary.draws.motions import random_motion
from tests.adversary.draws.robots import random_robot
from tests.adversary.judge.bounds import BOUNDS, build
from tests.adversary.judge.surroundings import Stage
from tests.adversary.judge.unchecked_pairs import declared

_SLACK = 2e-6
_OFFS = (-1e-1, -1e-2, -1e-3, -1e-4, -1e-5, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
# By more than this share of the size a constraint is kept without doubt.
_WIDE = 0.5e-3


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a robot, a motion of it, and constraints that it all but keeps."""
    robot = random_robot(rng, inertias=False)
    for joint in robot["joints"]:
        if joint["type"] == "floating":
            joint.update(xyz=[0.0] * 3, rpy=[0.0] * 3)
    case: Document = {"kind": "constraints", "robot": robot, "objects": []}
    for i in range(2):
        xyz = 3 * robot["size"] * rng.normal(size=3)
        box = {"box": (robot["size"] * rng.uniform(0.1, 1, size=3)).tolist()}
        case["objects"].append({
            "name": f"o{i}",
            "shape": box,
            "xyz": xyz.tolist(),
            "rpy": [0.0] * 3,
        })
    setting = Setting.lay_out(case, folder)
    stage = Stage.of(setting)
    case["questions"] = []
    for _ in range(4):
        motion = free_motion(rng, stage) or random_motion(rng, stage.robot.leaders, size=stage.size)
        name = str(rng.choice(list(BOUNDS)))
        bound = BOUNDS[name].draw(rng, stage, motion, float(rng.choice(_OFFS)))
        if bound is not None:
            case["questions"].append({"motion": motion, "constraint": {"type": name, **bound}})
    return case


def judge(case: Document, folder: Path) -> Outcome:
    """Ask about every constraint and hold the answers against samples."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    stage = Stage.of(setting)
    stage.unchecked = declared(setting, stage)
    for question in case["questions"]:
        entry = question["constraint"]
        outcome.count("asked")
        begin = time.process_time()
        try:
            answer = setting.ask(question, **build(entry))
        except Exception as fault:  # noqa: BLE001  (any that is not an answer is a defect)
            outcome.blame("error", f"{entry['type']}: {fault!r}", 16)
            continue
        outcome.count(f"longest {entry['type']} [s]", time.process_time() - begin)
        if isinstance(answer, planning.errors.DeadlineExceeded):
            outcome.blame("no answer", f"{entry['type']}: {answer}", 16)
        elif isinstance(answer, planning.errors.ProblemInvalid) and "no two" in str(answer):
            # The right answer to a band between bodies none of which can come nearer to another.
            outcome.count(f"{entry['type']} without a pair")
        elif isinstance(answer, Exception):
            outcome.blame("error", f"{entry['type']}: {answer!r}")
        else:
            _hold(outcome, stage, question, answer[0])
    return outcome


def _hold(outcome: Outcome, stage: Stage, question: Document, certificate: Any) -> None:
    entry = question["constraint"]
    kind = BOUNDS[entry["type"]]
    check = check_of(certificate, kind.check(entry))
    excess = kind.excess(stage, question["motion"], entry)
    outcome.count(f"{entry['type']} passed", check.passed)
    said = f"says {check.value:.9g} of {check.bound:.9g} +- {check.resolution:.3g}"
    told = f"beyond its bound by {excess:.6g} {check.unit}; {said}"
    if check.passed and excess > _SLACK + 1e-8 * stage.size + kind.share * abs(check.bound):
        outcome.blame(entry["type"], told)
    if excess < 0:
        outcome.count(f"{entry['type']} kept")
    if not check.passed and excess < -_WIDE * kind.unit(stage, check):
        outcome.refuse(entry["type"], told, 16)
