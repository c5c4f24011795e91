"""Attack on torques: limits of effort just above or below what a motion takes, with payloads."""

from pathlib import Path

import numpy as np

from tests.adversary.cases import Document, Outcome, Setting, check_of
from tests.adversary.draws.motions import random_motion
from tests.adversary.draws.payloads import payloads_of, random_payloads
from tests.adversary.draws.robots import SCALARS, random_robot
from tests.adversary.judge.dynamics import torques

_FACTORS = (0.5, 0.9, 0.99, 1.01, 1.1, 2.0)
# Differences are exact to this share; a proof may be wider by ten times that.
_SHARE, _WIDE = 1e-3, 1e-2


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a robot that weighs something and whose motors are just strong enough, or not."""
    size = float(rng.choice([0.1, 1.0, 1.0, 10.0]))
    robot = random_robot(
        rng, kinds=(*SCALARS, *SCALARS, "fixed"), inertias=True, mimics=0.15, size=size
    )
    for link in robot["links"]:
        link["shapes"] = []
    turn = rng.uniform(-3, 3, size=3) * (rng.random() < 0.5)
    case: Document = {"kind": "torques", "robot": robot, "objects": []}
    case["base"] = [[0.0] * 3, turn.tolist()]
    held, options = random_payloads(rng, robot)
    case["objects"] += [held] if held else []
    setting = Setting.lay_out(case, folder)
    motion = random_motion(
        rng, setting.robot.leaders, size=size, duration=float(10 ** rng.uniform(-0.3, 1))
    )
    case["questions"] = [{"motion": motion, "options": {"effort": True, **options}}]
    found = torques(setting.robot, setting.base, motion, payloads_of(case))
    peaks = {name: float(np.abs(row).max()) for name, row in found.items()}
    victim = str(rng.choice(list(peaks)))
    for joint in robot["joints"]:
        if joint["name"] in peaks:
            factor = (
                float(rng.choice(_FACTORS))
                if joint["name"] == victim or rng.random() < 0.2
                else 10.0
            )
            joint["effort"] = max(peaks[joint["name"]] * factor, 1e-6 * size)
    return case


def judge(case: Document, folder: Path) -> Outcome:
    """Ask, and hold the answer against torques by differences."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    (question,) = case["questions"]
    answer = setting.ask(question)
    outcome.count("asked")
    if isinstance(answer, Exception):
        outcome.blame("error", f"{type(answer).__name__}: {answer}")
        return outcome
    robot = setting.robot
    own = torques(robot, setting.base, question["motion"], payloads_of(case))
    uses = {
        name: float(np.abs(row).max()) / robot.by_name[name].effort for name, row in own.items()
    }
    name, use = max(uses.items(), key=lambda item: item[1])
    check = check_of(answer[0], "torque")
    outcome.count("torque passed", check.passed)
    told = f"{name} takes {use:.6g} of its effort; says {check.where} {check.value:.6g}"
    if check.passed and use > 1 + _SHARE:
        outcome.blame("torque", told)
    if not check.passed and use < 1 - _WIDE:
        outcome.refuse("torque", told)
    return outcome
