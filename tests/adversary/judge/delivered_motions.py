"""What motions that were delivered keep: exactly, and as a receiver reads their samples."""

import numpy as np

from tests.adversary.cases import Document, Outcome, Setting
from tests.adversary.draws.motions import hermite
from tests.adversary.judge.clearance_judge import SHARE, SLACK
from tests.adversary.judge.peaks import ORDERS, all_peaks, all_ranges
from tests.adversary.judge.surroundings import Look, Stage
from tests.adversary.judge.unchecked_pairs import declared

# Rates of samples are read with rounding in them.
_RATE = 1e-3


def of_polynomial(names: list[str], polynomial: Document) -> Document:
    bases, powers = np.array(polynomial["bases"]), np.array(polynomial["coefficients"])
    parts = {
        name.removeprefix("r::"): {
            "bases": bases[:, [i]].tolist(),
            "coefficients": powers[:, :, [i]].tolist(),
        }
        for i, name in enumerate(names)
    }
    return {"breaks": polynomial["breaks"], "joints": parts}


def read_samples(names: list[str], told: Document, kind: str) -> Document:
    """Return the motion that samples stand for."""
    times = np.array(told["times"])
    p, v, a = (np.array(told[name]) for name in ("positions", "velocities", "accelerations"))
    parts: Document = {}
    for i, name in enumerate(names):
        pieces = []
        for k, h in enumerate(np.diff(times)):
            step, two = p[k + 1, [i]] - p[k, [i]], slice(k, k + 2)
            if kind == "linear":
                pieces.append([[0.0], (step / h).tolist()])
            else:
                degree = 3 if kind == "cubic" else 5
                pieces.append(hermite(h, step, v[two][:, [i]], a[two][:, [i]], degree).tolist())
        parts[name.removeprefix("r::")] = {"bases": p[:-1, [i]].tolist(), "coefficients": pieces}
    return {"breaks": times.tolist(), "joints": parts}


def hold_delivered(
    outcome: Outcome, setting: Setting, stage: Stage, what: tuple[str, int], motion: Document
) -> None:
    """Hold a motion against limits as the file has them, and against obstacles.

    Args:
        outcome: Where to tell what is wrong.
        setting: Of the case.
        stage: With all that stands there.
        what: What the motion is called, and the number of the defect that it would be.
        motion: As the judge reads it.
    """
    label, number = what
    robot = setting.robot
    for name, (low, high) in all_ranges(robot, motion).items():
        joint = robot.by_name[name]
        excess = max(joint.lower - low, high - joint.upper)
        if np.isfinite(joint.lower) and excess > 2e-6:
            outcome.blame(
                label, f"{name} {excess:.4g} beyond its position", 5 if joint.leader else number
            )
    orders = ["velocity"] if "linear" in label else ["velocity", "acceleration"]
    for rate in orders:
        for (name, _), top in all_peaks(robot, motion, ORDERS[rate]).items():
            joint = robot.by_name[name]
            # Where a file states no acceleration, it is two times the velocity.
            limit = joint.velocity * (1.0 if rate == "velocity" else 2.0)
            if top > limit * (1 + _RATE) and not (joint.leader and rate != "velocity"):
                outcome.blame(
                    label,
                    f"{name} at {top / limit:.4g} of its {rate}",
                    5 if joint.leader else number,
                )
    seen = stage.worst(motion, Look(skip=declared(setting, stage)))
    if seen is not None and seen.distance < -SLACK - SHARE * stage.size:
        outcome.blame(
            label,
            f"{seen.near.pair} {seen.distance:.6g} m apart at {seen.time:.4g} s",
            number or stage.suspect,
        )
