"""Attack on rounding: polynomials of a high degree, made in Bernstein's form and turned exactly."""

from fractions import Fraction
from math import comb
from pathlib import Path

import numpy as np

from tests.adversary.cases import Document, Outcome, Setting
from tests.adversary.draws.motions import exact_tangent

_LOOKS = 120


def draw(rng: np.random.Generator, _: Path) -> Document:
    """Return a joint that moves by a polynomial of degree up to 40 within +-1."""
    degree, width = int(rng.integers(3, 41)), float(2.0 ** rng.integers(-3, 4))
    corners = rng.uniform(-1, 1, size=degree + 1)
    corners[:2], corners[-2] = 0, corners[-1]
    powers = []
    for k in range(degree + 1):
        signed = [(-1) ** (k - i) * comb(k, i) * Fraction(float(corners[i])) for i in range(k + 1)]
        powers.append(float(Fraction(comb(degree, k)) * sum(signed) / Fraction(width) ** k))
    part = {"bases": [[0.0]], "coefficients": [[[power] for power in powers]]}
    limit = float(rng.choice([0.3, 0.6, 0.9, 1.0]))
    joint = {"name": "j0", "type": "revolute", "parent": "base", "child": "l0", "xyz": [0.0] * 3}
    joint |= {"rpy": [0.0] * 3, "axis": [1.0, 0.0, 0.0], "lower": -limit, "upper": limit}
    joint |= {"velocity": 1e6, "effort": 1.0}
    links = [{"name": "base", "shapes": []}, {"name": "l0", "shapes": []}]
    motion = {"breaks": [0.0, width], "joints": {"j0": part}}
    robot = {"size": 1.0, "links": links, "joints": [joint]}
    return {"kind": "polynomial_degrees", "robot": robot, "questions": [{"motion": motion}]}


def judge(case: Document, folder: Path) -> Outcome:
    """Hold the bound on positions, which is guaranteed, against the exact polynomial."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    (question,) = case["questions"]
    answer = setting.ask(question)
    outcome.count("asked")
    if isinstance(answer, Exception):
        outcome.count(f"refused: {type(answer).__name__}")
        return outcome
    checks = [check for check in answer[0].checks if check.name == "position"]
    motion, (joint,) = question["motion"], case["robot"]["joints"]
    for check in checks:
        part, width = motion["joints"]["j0"], motion["breaks"][-1]
        places = np.linspace(0, width, _LOOKS)
        top = max(abs(float(exact_tangent(part, 0, float(t)))) for t in places)
        excess = top - joint["upper"]
        outcome.count("position passed", check.passed)
        if excess > check.value + check.resolution + 1e-9:
            degree = len(part["coefficients"][0]) - 1
            said = (
                f"at most {check.value:.9g} beyond the limit, it is {excess:.9g}, degree {degree}"
            )
            outcome.blame("position of high degree", said, 12)
    return outcome
