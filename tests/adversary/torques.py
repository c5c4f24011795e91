"""Attack on torques: limits of effort just above or below what a motion takes."""

from pathlib import Path

import numpy as np

from tests.adversary.cases import Document, Outcome, Setting, check_of
from tests.adversary.dynamics import torques
from tests.adversary.motions import random_motion
from tests.adversary.robots import SCALARS, random_robot

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
    case: Document = {"kind": "torques", "robot": robot, "objects": []}
    setting = Setting.lay_out(case, folder)
    motion = random_motion(
        rng, setting.robot.leaders, size=size, duration=float(10 ** rng.uniform(-0.3, 1))
    )
    peaks = {
        k: float(np.abs(v).max()) for k, v in torques(setting.robot, setting.base, motion).items()
    }
    victim = str(rng.choice(list(peaks)))
    for joint in robot["joints"]:
        if joint["name"] in peaks:
            factor = (
                float(rng.choice(_FACTORS))
                if joint["name"] == victim or rng.random() < 0.2
                else 10.0
            )
            joint["effort"] = max(peaks[joint["name"]] * factor, 1e-6 * size)
    case["questions"] = [{"motion": motion, "options": {"effort": True}}]
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
    own = torques(robot, setting.base, question["motion"])
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
