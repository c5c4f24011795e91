"""Attack on the limits of joints, of followers too: limits just above or below peaks.

The motion comes first; then each limit is put a little above or a little below what it reaches.
"""

from pathlib import Path
from typing import Any

import numpy as np

from tests.adversary.cases import Document, Outcome, Setting, check_of
from tests.adversary.draws.motions import random_motion, slowed
from tests.adversary.draws.robots import SCALARS, random_robot
from tests.adversary.judge.kinematics import Robot
from tests.adversary.judge.peaks import ORDERS, all_peaks, all_ranges, blocks_of

# A rate is kept to a millionth of its limit, a position to 1e-6; sampled norms are less sharp.
SLACK = 1.5e-6
WIDE = 2e-3
# A card states at most 10,000, which leaves ten times as much for what is not tight.
_FASTEST = 900.0
_FACTORS = (0.5, 0.9, 0.999, 1 - 1e-5, 1 + 1e-5, 1.003, 1.1, 2.0)


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a robot whose limits are near what its motion needs."""
    robot = random_robot(rng, shapes=("box", "sphere"), mimics=0.5)
    for joint in robot["joints"]:
        if joint["type"] == "floating":
            joint.update(xyz=[0.0] * 3, rpy=[0.0] * 3)
    for link in robot["links"]:
        link["shapes"] = link["shapes"][:1] if link["name"] == robot["links"][-1]["name"] else []
    case: Document = {"kind": "rates", "robot": robot, "objects": []}
    read = Setting.lay_out(case, folder).robot
    motion = _in_reach(read, random_motion(rng, read.leaders, size=robot["size"]))
    case["card"] = _card(rng, read, motion, robot)
    method = str(rng.choice(["toppra", "ruckig"]))
    case["questions"] = [{"motion": motion, "options": {"method": method}}]
    return case


def _in_reach(read: Robot, motion: Document) -> Document:
    """Return a motion slowed until every rate is one that a card may state."""
    slow = 1.0
    for order in ORDERS.values():
        top = max(all_peaks(read, motion, order).values())
        slow = max(slow, (top / _FASTEST) ** (1 / order))
    return slowed(motion, slow)


def _card(rng: np.random.Generator, read: Robot, motion: Document, robot: Document) -> Document:
    """Write limits into the robot's file, of positions, and into a card, of rates."""
    tight = str(rng.choice(["position", "velocity", "acceleration", "jerk", "all"]))
    moving = [joint for joint in read.joints if joint.kind != "fixed"]
    followers = [joint for joint in moving if joint.leader]
    of = followers if followers and rng.random() < 0.5 else moving
    victim = of[int(rng.integers(len(of)))].name

    def near(what: str, joint: str) -> float:
        is_near = tight in {what, "all"} and (joint == victim or rng.random() < 0.2)
        return float(rng.choice(_FACTORS)) if is_near else 10.0

    ranges = all_ranges(read, motion)
    for joint in robot["joints"]:
        if joint["type"] in SCALARS:
            low, high = ranges[joint["name"]]
            half, middle = (high - low) / 2 + 1e-3, (high + low) / 2
            joint["lower"] = middle - half * near("position", joint["name"])
            joint["upper"] = middle + half * near("position", joint["name"])
    limits: Document = {}
    for what, order in ORDERS.items():
        for (name, block), top in all_peaks(read, motion, order).items():
            entry = limits.setdefault(name, {})
            entry = entry.setdefault(block, {}) if block else entry
            entry[what] = max(top, 1e-6) * near(what, name)
    leaders = [joint.name for joint in read.leaders]
    groups = {"all": {"joints": leaders}}
    head = {"name": "m", "file": "robot.urdf", "base": "base", "default_group": "all"}
    return {**head, "groups": groups, "limits": limits}


def judge(case: Document, folder: Path) -> Outcome:
    """Ask whether the limits are kept and hold the answer against the true peaks."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    for question in case["questions"]:
        answer = setting.ask(question)
        outcome.count("asked")
        if isinstance(answer, Exception):
            outcome.blame("error", f"{type(answer).__name__}: {answer}")
            continue
        for what in _judged(question):
            _hold(outcome, setting, question, what, answer[0])
    return outcome


def _judged(question: Document) -> list[str]:
    rates = ["position", "velocity", "acceleration", "jerk"]
    return rates if question["options"]["method"] == "ruckig" else rates[:3]


def _hold(
    outcome: Outcome, setting: Setting, question: Document, what: str, certificate: Any
) -> None:
    check = check_of(certificate, what)
    uses = excesses(setting, question["motion"], what)
    outcome.count(f"{what} passed", check.passed)
    (joint, block, own), excess = max(uses.items(), key=lambda item: item[1] - item[0][2])
    unit = "rad or m" if what == "position" else "of it"
    told = f"{joint} {block} is beyond its {what} by {excess:.6g} ({unit})"
    if check.passed and excess > own:
        is_follower = bool(setting.robot.by_name[joint].leader)
        outcome.blame(f"{what}, follower" if is_follower else what, told, 5 if is_follower else 0)
    if not check.passed and excess < -WIDE:
        told += f"; says {check.where} {check.value:.9g} of {check.bound:.9g}"
        outcome.refuse(what, told)


def excesses(setting: Setting, motion: Document, what: str) -> dict[tuple[str, str, float], float]:
    """Return by how much each joint is beyond its limit, and how much of that is nothing."""
    robot, found = setting.robot, {}
    if what == "position":
        for name, (low, high) in all_ranges(robot, motion).items():
            joint = robot.by_name[name]
            if np.isfinite(joint.lower):
                found[name, "", SLACK] = max(joint.lower - low, high - joint.upper)
        return found or {("", "", SLACK): -np.inf}
    limits = setting.case["card"]["limits"]
    for (name, block), top in all_peaks(robot, motion, ORDERS[what]).items():
        entry = limits[name][block] if block else limits[name]
        joint = robot.by_name[name]
        sharp = len(blocks_of(joint.kind)[block]) == 1 or what == "velocity"
        found[name, block, SLACK if sharp else 1e-3] = top / entry[what] - 1
    return found
