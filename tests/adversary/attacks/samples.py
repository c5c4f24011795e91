"""Attack on samples: of motions that are proven, read as straight lines and as polynomials.

What is said to be proven of a reading must be so of the motion that a receiver makes of it; and
samples no farther apart than `up_to_period` must be proven too.
"""

import time
from pathlib import Path
from typing import Any

import numpy as np

import planning
from planning.api.sample_motion import sample_motion
from planning.domain.curves.sampling import Sampling
from planning.errors import WayproofError
from tests.adversary.attacks.clearance import free_motion, held_thing
from tests.adversary.cases import PATIENCE, Document, Outcome, Setting
from tests.adversary.draws.motions import slowed
from tests.adversary.draws.obstacles import random_obstacle
from tests.adversary.draws.robots import SCALARS, random_robot
from tests.adversary.judge.delivered_motions import hold_delivered, read_samples
from tests.adversary.judge.peaks import ORDERS, all_peaks
from tests.adversary.judge.surroundings import Stage

# What an obstacle is apart from what moves, as a share of the size.
_GAPS = (1e-5, 1e-4, 1e-3, 1e-2)
# Nearer samples than these are too many to look at [s, of the duration].
_FINEST = 1e-3


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a motion within limits, near obstacles, and how it shall be sampled."""
    size = float(rng.choice([0.1, 1.0, 1.0, 10.0]))
    for _ in range(6):
        robot = random_robot(rng, kinds=(*SCALARS, "fixed"), size=size, mimics=0.2)
        case: Document = {"kind": "samples", "robot": robot, "objects": []}
        if rng.random() < 0.3:
            case["objects"].append(held_thing(rng, robot))
        stage = Stage.of(Setting.lay_out(case, folder))
        motion = free_motion(rng, stage, pieces=int(rng.integers(1, 4)))
        if motion is not None:
            break
    else:
        return draw(rng, folder)
    motion = _within(rng, stage, motion)
    for i in range(int(rng.integers(1, 4))):
        case["objects"].append(random_obstacle(rng, stage, motion, f"o{i}", _GAPS))
        stage.add(case["objects"][-1])
    width = motion["breaks"][-1]
    period = float(width * 10 ** rng.uniform(-2, -0.3))
    sampling = [{"period": period}, {"num_points": int(rng.integers(2, 12))}]
    chosen = [*sampling, {"period": period, "is_even": True}][int(rng.integers(3))]
    known = bool(rng.random() < 0.7)
    case["questions"] = [{"motion": motion, "sampling": chosen, "knows_clearance": known}]
    return case


def _within(rng: np.random.Generator, stage: Stage, motion: Document) -> Document:
    """Return a motion slowed until it keeps its limits, by little or by much."""
    slow = 0.0
    for order in (ORDERS["velocity"], ORDERS["acceleration"]):
        for (name, _), top in all_peaks(stage.robot, motion, order).items():
            limit = stage.robot.by_name[name].velocity * order
            slow = max(slow, (top / limit) ** (1 / order))
    return slowed(motion, max(slow, 1e-3) * float(rng.choice([1.0001, 1.01, 1.2, 3.0])))


def judge(case: Document, folder: Path) -> Outcome:
    """Sample what is proven, and hold every reading that is said to be proven."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    stage = Stage.of(setting)
    for question in case["questions"]:
        outcome.count("asked")
        answer = setting.ask(question)
        if isinstance(answer, Exception):
            outcome.blame("error", f"{type(answer).__name__}: {answer}")
        elif answer[0].proven:
            outcome.count("proven")
            known = question["knows_clearance"]
            clearance = answer[0].min_clearance if known else -np.inf
            _sample(outcome, setting, stage, question, clearance)
    return outcome


def _sample(
    outcome: Outcome, setting: Setting, stage: Stage, question: Document, clearance: float
) -> None:
    longest = question["motion"]["breaks"][-1]
    # Of samples that are evenly apart it is said of these alone.
    follows = Sampling(**question["sampling"]).follows_pieces
    told = _told(outcome, setting, question, question["sampling"], clearance)
    for proof in told.interpolations if told else ():
        outcome.count(f"{proof.kind} proven", proof.proven)
        if proof.proven:
            _hold(outcome, setting, stage, told.samples, proof.kind)
        period = proof.up_to_period
        if not follows or period is None or not _FINEST * longest < period:
            continue
        outcome.count(f"{proof.kind} proven up to a period")
        again = _told(outcome, setting, question, {"period": min(period, longest)}, clearance)
        for other in again.interpolations if again else ():
            if other.kind == proof.kind and not other.proven:
                said = f"said of {period:.6g} s, but {other.failed or other.reason}"
                outcome.blame(f"samples up to a period, {proof.kind}", said, 3)
        if again:
            _hold(outcome, setting, stage, again.samples, proof.kind)


def _told(
    outcome: Outcome, setting: Setting, question: Document, sampling: Document, clearance: float
) -> Any:
    deadline = planning.Deadline.after(PATIENCE, time.process_time)
    curve, how = setting.curve(question["motion"]), Sampling(**sampling)
    how_far = {"deadline": deadline, "clearance": clearance}
    try:
        return sample_motion(setting.world, "r", curve, how, **how_far)
    except WayproofError as fault:
        outcome.blame("error", f"samples: {type(fault).__name__}: {fault}")
        return None


def _hold(outcome: Outcome, setting: Setting, stage: Stage, samples: Any, kind: str) -> None:
    rows = ("times", "positions", "velocities", "accelerations")
    told = {name: getattr(samples, name).tolist() for name in rows}
    names = [joint.name for joint in setting.group.joints]
    motion = read_samples(names, told, kind)
    hold_delivered(outcome, setting, stage, (f"samples, {kind}", 3), motion)
