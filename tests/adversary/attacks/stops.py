"""Attack on stops: how long and how far the longest goes, and those that `stop_motion` makes.

From speed v no stop within limits a and j takes less than v / a + a / (2 j), or sqrt(2 v / j) where
that never uses all of a; nor is any shorter than v^2 / (2 a). What is reported is said to be no
less, from every instant.
"""

import time
from pathlib import Path
from typing import Any

import numpy as np

import planning
from planning.errors import NotCertified, RetimingFailed
from tests.adversary.attacks.clearance import free_motion
from tests.adversary.cases import PATIENCE, Document, Outcome, Setting, check_of, options_of
from tests.adversary.draws.motions import around, positions, sample_places, slowed, tangents
from tests.adversary.draws.obstacles import random_obstacle
from tests.adversary.draws.robots import SCALARS, random_robot
from tests.adversary.judge.delivered_motions import hold_delivered, of_polynomial
from tests.adversary.judge.peaks import ORDERS, all_peaks, extremes
from tests.adversary.judge.surroundings import Stage

# What a file's velocity makes of limits on acceleration and jerk that it does not state.
_ASSUMED = {1: 1.0, 2: 2.0, 3: 20.0}
_GAPS = (1e-6, 1e-5, 1e-4, 1e-2)
_SAME, _SHARE = 1e-5, 1e-3


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a motion within limits, which of them may differ by sign, and when to stop it."""
    size = float(rng.choice([0.1, 1.0, 1.0, 10.0]))
    robot = random_robot(rng, kinds=(*SCALARS, "fixed"), size=size, mimics=0.3)
    for joint in robot["joints"]:
        if "mimic" in joint:
            # So that what follows may be what limits a stop.
            joint["velocity"] *= float(10 ** rng.uniform(-1, 0))
    case: Document = {"kind": "stops", "robot": robot, "objects": []}
    stage = Stage.of(Setting.lay_out(case, folder))
    motion = free_motion(rng, stage, pieces=int(rng.integers(1, 4)), degree=5)
    if motion is None:
        return draw(rng, folder)
    jerk = bool(rng.random() < 0.4)
    motion = slowed(motion, _least(stage, motion, jerk=jerk) * float(rng.choice([1.001, 1.1, 2.0])))
    for i in range(int(rng.choice([0, 2, 4]))):
        case["objects"].append(random_obstacle(rng, stage, motion, f"o{i}", _GAPS))
        stage.add(case["objects"][-1])
    question: Document = {"motion": motion, "options": {"method": "ruckig" if jerk else "toppra"}}
    if rng.random() < 0.4:
        question["options"]["acceleration_bounds"] = _bounds(rng, stage, motion)
    question |= {"at": float(rng.uniform(0.05, 0.95)), "along": bool(rng.random() < 0.5)}
    question["most"] = float(10 ** rng.uniform(-1, 1)) if rng.random() < 0.5 else None
    case["questions"] = [question]
    return case


def _least(stage: Stage, motion: Document, *, jerk: bool) -> float:
    """Return how much longer a motion must take to keep its limits."""
    slow = 1e-3
    for order in list(ORDERS.values())[: 3 if jerk else 2]:
        for (name, _), top in all_peaks(stage.robot, motion, order).items():
            limit = stage.robot.by_name[name].velocity * _ASSUMED[order]
            slow = max(slow, (top / limit) ** (1 / order))
    return slow


def _bounds(rng: np.random.Generator, stage: Stage, motion: Document) -> Document:
    """Return bounds by sign on the acceleration of a joint, which its motion keeps."""
    name = str(rng.choice([joint.name for joint in stage.robot.leaders]))
    low, high = extremes(motion["joints"][name], np.array(motion["breaks"]), 0, 2)
    room = rng.choice([1.001, 1.3, 3.0], size=2)
    return {f"r::{name}": [min(low, -1e-6) * room[0], max(high, 1e-6) * room[1]]}


def judge(case: Document, folder: Path) -> Outcome:
    """Ask how long stops take, stop the motion, and hold both against what is possible."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    stage = Stage.of(setting)
    for question in case["questions"]:
        outcome.count("asked")
        wanted = planning.CertifyOptions(stop_anywhere=True, max_stopping_time=question["most"])
        answer = setting.ask(question, certify_options=wanted)
        if isinstance(answer, Exception):
            outcome.blame("error", f"{type(answer).__name__}: {answer}")
        elif answer[1].stop is not None:
            outcome.count("told")
            _hold_bounds(outcome, setting, question, *answer)
            _stop(outcome, setting, stage, question)
    return outcome


def _hold_bounds(
    outcome: Outcome, setting: Setting, question: Document, certificate: Any, report: Any
) -> None:
    longest, farthest = _possible(setting, question)
    stop, check = report.stop, check_of(certificate, "stop")
    outcome.count("stop passed", check.passed)
    if stop.time < longest * (1 - _SHARE):
        outcome.blame("stop: time", f"{stop.time:.6g} s, but one takes {longest:.6g} s at least")
    if stop.distance < farthest * (1 - _SHARE):
        said = f"{stop.distance:.6g} rad or m, but one goes {farthest:.6g} at least"
        outcome.blame("stop: distance", said)
    if question["most"] and check.passed and longest > question["most"] * (1 + _SHARE):
        outcome.blame("stop: most", f"{longest:.6g} s at least, {question['most']:.6g} s asked for")


def _possible(setting: Setting, question: Document) -> tuple[float, float]:
    """Return how long the longest stop takes at least [s], and how far a joint goes in one."""
    motion, robot = question["motion"], setting.robot
    pieces, local, _ = sample_places(motion, 400)
    signed = question["options"].get("acceleration_bounds", {})
    longest = farthest = 0.0
    for joint in robot.joints:
        if joint.kind == "fixed":
            continue
        leader, factor = robot.factor(joint.name)
        speeds = factor * tangents(motion["joints"][leader], pieces, local, 1)[:, 0]
        jerk = joint.velocity * _ASSUMED[3] if question["options"]["method"] == "ruckig" else np.inf
        low, high = signed.get(f"r::{joint.name}", (-np.inf, np.inf))
        limit = joint.velocity * _ASSUMED[2]
        hard = np.where(speeds > 0, min(limit, -low), min(limit, high))
        speeds = np.abs(speeds)
        is_short = speeds < hard**2 / (2 * jerk)
        times = np.where(is_short, np.sqrt(2 * speeds / jerk), speeds / hard + hard / (2 * jerk))
        longest = max(longest, float(times.max()))
        if not joint.leader:
            farthest = max(farthest, float((speeds**2 / (2 * hard)).max()))
    return longest, farthest


def _stop(outcome: Outcome, setting: Setting, stage: Stage, question: Document) -> None:
    """Stop the motion, and hold the stop against what every motion keeps."""
    running = setting.curve(question["motion"])
    when, along = question["at"] * running.duration, question["along"]
    deadline = planning.Deadline.after(PATIENCE, time.process_time)
    try:
        found = planning.stop_motion(
            setting.world,
            "r",
            running,
            when,
            deadline=deadline,
            options=options_of(question),
            along_path=along,
        )
    except (RetimingFailed, NotCertified) as fault:
        outcome.count(f"no stop{' along' if along else ''}: {type(fault).__name__}")
        return
    outcome.count("stopped along the path" if along else "stopped")
    curve, names = found.trajectory, [joint.name for joint in setting.group.joints]
    rows = {name: getattr(curve, name) for name in ("breaks", "bases", "coefficients")}
    motion = of_polynomial(names, {**rows, "breaks": curve.breaks.tolist()})
    _hold_ends(outcome, stage, question, when, motion)
    if along:
        _hold_path(outcome, question, when, motion)
    hold_delivered(outcome, setting, stage, ("stop", 0), motion)


def _hold_ends(
    outcome: Outcome, stage: Stage, question: Document, when: float, motion: Document
) -> None:
    """A stop begins where the motion is and as fast, and ends at rest."""
    here = around(question["motion"], when, 0.0, 1)[:2]
    ends = [sample_places(motion, 3)[k][[0, -1]] for k in (0, 1)]
    for joint in stage.robot.leaders:
        part, own = question["motion"]["joints"][joint.name], motion["joints"][joint.name]
        place = positions(question["motion"], *here)[joint.name][0, 0]
        off = abs(positions(motion, *ends)[joint.name][0, 0] - place)
        speed = tangents(part, *here, 1)[0, 0]
        first, last = tangents(own, *ends, 1)[:, 0]
        if off > _SAME or abs(first - speed) > 1e-4 * joint.velocity or abs(last) > _SAME:
            said = f"{joint.name} begins {off:.4g} off, at {first:.6g} and not {speed:.6g}"
            outcome.blame("stop: ends", f"{said}, and ends at {last:.4g}")


def _hold_path(outcome: Outcome, question: Document, when: float, motion: Document) -> None:
    """A stop along the path is nowhere else, and never goes back."""
    pieces, local, _ = sample_places(motion, 60)
    at = np.linspace(when, question["motion"]["breaks"][-1], 4000)
    breaks = np.array(question["motion"]["breaks"])
    on = np.clip(np.searchsorted(breaks, at, side="right") - 1, 0, len(breaks) - 2)
    own, path = positions(motion, pieces, local), positions(question["motion"], on, at - breaks[on])
    own, path = (np.concatenate([q[n] for n in sorted(q)], axis=1) for q in (own, path))
    reach = np.abs(np.diff(path, axis=0)).max(initial=0.0)
    gaps = np.abs(own[:, None, :] - path[None]).max(axis=2)
    if gaps.min(axis=1).max() > reach + _SAME:
        outcome.blame("stop: path", f"{gaps.min(axis=1).max():.4g} off the path")
