"""Attack on continuity: steps of position, velocity or acceleration, each too small to be seen.

Between any two instants a joint may go no farther than its limit allows, gain no more speed and, if
jerk is limited, no more acceleration; one step of each within what counts as rounding is forgiven.
"""

from pathlib import Path

import numpy as np

from planning.domain.arrays import Array
from tests.adversary.cases import Document, Outcome, Setting
from tests.adversary.draws.motions import sample_places, tangents
from tests.adversary.judge.peaks import rise

# What one step may be, in position [rad or m] and as shares of the limits of rates.
ROUNDING = {0: 1e-6, 1: 1e-5, 2: 1e-3}
_LIMITS = (1.0, 2.0, 20.0)


def draw(rng: np.random.Generator, _: Path) -> Document:
    """Return a slide that goes up stairs and, of rates, down again."""
    order = int(rng.integers(3))
    count = int(10 ** rng.uniform(0.5, 3.5))
    share = float(rng.uniform(0.3, 0.99)) * (1.0 if rng.random() < 0.8 else 1.5)
    step = share * ROUNDING[order] * (1.0, *_LIMITS)[order]
    width = float(10 ** rng.uniform(-8, -2))
    levels, widths = _stairs(order, count, step, width)
    if order == 0 and rng.random() < 0.3:
        levels = levels * np.resize([1, -1], len(levels))
    joint = {"name": "j0", "type": "prismatic", "parent": "base", "child": "l0", "xyz": [0.0] * 3}
    joint |= {"rpy": [0.0] * 3, "axis": [1.0, 0.0, 0.0], "lower": -9.0, "upper": 9.0}
    joint |= {"velocity": 1.0, "effort": 1.0}
    links = [{"name": "base", "shapes": []}, {"name": "l0", "shapes": []}]
    return {
        "kind": "discontinuities",
        "robot": {"size": 1.0, "links": links, "joints": [joint]},
        "questions": [
            {
                "motion": _motion(order, levels, widths),
                "options": {"method": "ruckig" if order == 2 else "toppra"},
            }
        ],
    }


def _stairs(order: int, count: int, step: float, width: float) -> tuple[Array, Array]:
    """Return a level and a width of each piece; it begins and ends at rest."""
    up = np.arange(count + 1) * step
    if order == 0:
        return up, np.full(count + 1, width)
    there = np.concatenate([up, up[-2::-1]])
    widths = np.full(len(there), width)
    widths[count] = max(width, 0.01)
    if order == 1:
        return there, widths
    return np.concatenate([there, -there[1:]]), np.concatenate([widths, widths[1:]])


def _motion(order: int, levels: Array, widths: Array) -> Document:
    """Return the motion whose derivative of some order has these levels."""
    rows, place = [], np.zeros(2)
    for level, width in zip(levels, widths, strict=True):
        match order:
            case 0:
                rows.append(([level], [0.0, 0.0, 0.0]))
            case 1:
                rows.append(([place[0]], [0.0, level, 0.0]))
                place = place + np.array([level * width, 0.0])
            case _:
                rows.append(([place[0]], [0.0, place[1], level / 2]))
                gone = place[1] * width + level * width**2 / 2
                place = place + np.array([gone, level * width])
    part = {
        "bases": [[float(x) for x in base] for base, _ in rows],
        "coefficients": [[[float(c)] for c in powers] for _, powers in rows],
    }
    return {"breaks": np.concatenate([[0.0], np.cumsum(widths)]).tolist(), "joints": {"j0": part}}


def judge(case: Document, folder: Path) -> Outcome:
    """Ask, and look at what the joint does between any two instants."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    (question,) = case["questions"]
    answer = setting.ask(question)
    outcome.count("asked")
    if isinstance(answer, Exception):
        outcome.blame("error", f"{type(answer).__name__}: {answer}")
        return outcome
    outcome.count("proven", answer[0].proven)
    if not answer[0].proven:
        return outcome
    motion = question["motion"]
    pieces, local, times = sample_places(motion, 1)
    part = motion["joints"]["j0"]
    for order in range(3 if question["options"]["method"] == "ruckig" else 2):
        values = tangents(part, pieces, local, order)[:, 0]
        if order == 0:
            values = values + np.array(part["bases"])[pieces, 0]
        excess = rise(times, values, _LIMITS[order])
        allowed = 3 * ROUNDING[order] * (1.0, *_LIMITS)[order]
        if excess > allowed:
            said = f"derivative {order} goes {excess:.4g} beyond the limit, {len(values)} samples"
            outcome.blame(f"jumps of derivative {order}", said, 10)
    return outcome
