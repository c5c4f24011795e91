"""Attack on bodies that float and turn: axes that move, over long and short pieces."""

from pathlib import Path

import numpy as np
from numpy.polynomial import polynomial

from tests.adversary.cases import Document, Outcome, Setting, check_of
from tests.adversary.judge.peaks import ORDERS, angular_peak

_WIDE = 0.02


def draw(rng: np.random.Generator, _: Path) -> Document:
    """Return a body that turns by cx about x at rest while it turns about y, or anyhow."""
    is_long = rng.random() < 0.4
    width = float(10 ** rng.uniform(*((2.5, 3.5) if is_long else (-0.5, 2.5))))
    power = int(rng.integers(5 if is_long else 1, 11))
    bump = polynomial.polymul([0.0] * power + [1.0], [1.0, -2.0, 1.0])
    swing = polynomial.polyint(bump)
    swing *= float(10 ** rng.uniform(-1, 1.8)) / polynomial.polyval(1.0, swing)
    rows = np.zeros((len(swing), 6))
    rows[:, 1] = swing / width ** np.arange(len(swing))
    rows[0, 1] -= rows[1:, 1] @ width ** np.arange(1, len(swing)) / 2 * (rng.random() < 0.6)
    rows[0, :3] += rng.uniform(-3, 3, size=3) * (rng.random(3) < 0.7)
    if rng.random() < 0.3:
        rows[1:, :3] = rows[1:, 1:2] * rng.normal(size=3)
    part = {"bases": [[1.0] + [0.0] * 6], "coefficients": [rows.tolist()]}
    motion = {"breaks": [0.0, width], "joints": {"j0": part}}
    factor = float(rng.choice([0.1, 0.5, 0.9, 0.99, 1.05, 2.0]))
    jerk = bool(rng.random() < 0.4)
    tops = {
        what: max(angular_peak(part, np.array([0, width]), order), 1e-15)
        for what, order in ORDERS.items()
    }
    if max(tops.values()) > 900 or min(tops.values()) < 1e-12:
        return draw(rng, _)
    what = str(
        rng.choice(["velocity", "acceleration", "jerk"] if jerk else ["velocity", "acceleration"])
    )
    rates = {name: top * (factor if name == what else 10.0) for name, top in tops.items()}
    # A card states no less than a millionth; a scale makes the rest of the way.
    scale = min(1.0, min(rates["acceleration"], rates["jerk"]) / 1e-5)
    rates |= {name: rates[name] / scale for name in ("acceleration", "jerk")}
    fast = {"velocity": 1e3, "acceleration": 1e3, "jerk": 1e3}
    card = {
        "name": "m",
        "file": "robot.urdf",
        "base": "base",
        "default_group": "all",
        "groups": {"all": {"joints": ["j0"]}},
        "limits": {"j0": {"linear": fast, "angular": rates}},
    }
    joint = {
        "name": "j0",
        "type": "floating",
        "parent": "base",
        "child": "l0",
        "xyz": [0.0] * 3,
        "rpy": [0.0] * 3,
    }
    shapes = [{"shape": {"box": [0.1, 0.1, 0.1]}, "xyz": [0.0] * 3, "rpy": [0.0] * 3}]
    links = [{"name": "base", "shapes": []}, {"name": "l0", "shapes": shapes}]
    question = {
        "motion": motion,
        "options": {"method": "ruckig" if jerk else "toppra", "acceleration_scale": scale},
    }
    robot = {"size": 1.0, "links": links, "joints": [joint]}
    return {"kind": "floats", "robot": robot, "card": card, "questions": [question]}


def judge(case: Document, folder: Path) -> Outcome:
    """Ask, and hold the answer against differences of the true angular velocity."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    (question,) = case["questions"]
    answer = setting.ask(question)
    outcome.count("asked")
    if isinstance(answer, Exception):
        outcome.blame("error", f"{type(answer).__name__}: {answer}")
        return outcome
    part, breaks = question["motion"]["joints"]["j0"], np.array(question["motion"]["breaks"])
    for what, limit in case["card"]["limits"]["j0"]["angular"].items():
        if what == "jerk" and question["options"]["method"] != "ruckig":
            continue
        check = check_of(answer[0], what)
        outcome.count(f"{what} passed", check.passed)
        scale = 1.0 if what == "velocity" else question["options"]["acceleration_scale"]
        use = angular_peak(part, breaks, ORDERS[what]) / (limit * scale)
        told = f"{use:.6g} of the limit, says {check.value:.6g}"
        if check.passed and use > 1 + 1e-3:
            outcome.blame(f"{what} of a body that floats", told, 11)
        if not check.passed and use < 1 - _WIDE:
            outcome.refuse(f"{what} of a body that floats", told, 16)
    return outcome
