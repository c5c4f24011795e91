"""Attack on `check_configurations`: its distances and verdicts against the judge's."""

from pathlib import Path

import numpy as np

import planning
from tests.adversary.attacks.clearance import held_thing
from tests.adversary.cases import Document, Outcome, Setting
from tests.adversary.draws.motions import around, positions, random_motion
from tests.adversary.draws.robots import random_robot
from tests.adversary.draws.shapes import KINDS, random_shape
from tests.adversary.judge.distances import Near, nearest
from tests.adversary.judge.surroundings import Look, Stage
from tests.adversary.judge.unchecked_pairs import declared

# Of a verdict [m], as a share of the size, and of a distance that is told.
_SLACK, _SHARE, _TOLD = 1.2e-6, 1e-7, 1e-8


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a robot among boxes and other shapes, and instants of a motion of it."""
    if rng.random() < 0.4:
        return _flat(rng, folder)
    boxes = rng.random() < 0.6
    robot = random_robot(
        rng, kinds=("revolute", "prismatic", "planar"), **({"shapes": ("box",)} if boxes else {})
    )
    size = robot["size"]
    case: Document = {"kind": "checks", "robot": robot, "objects": []}
    if rng.random() < 0.2:
        case["objects"].append(held_thing(rng, robot))
    for i in range(int(rng.integers(1, 4))):
        kinds = ("box",) if boxes else KINDS
        xyz, rpy = size * rng.normal(size=3), rng.uniform(-3, 3, size=3) * (rng.random() < 0.5)
        shape = random_shape(rng, size * 10 ** rng.uniform(-0.7, 0.3), kinds)
        case["objects"].append({
            "name": f"o{i}",
            "shape": shape,
            "xyz": xyz.tolist(),
            "rpy": rpy.tolist(),
        })
    return _asked(rng, case, folder)


def _flat(rng: np.random.Generator, folder: Path) -> Document:
    """Return a box that is pushed about among boxes on one floor: all share an axis."""
    size = float(10.0 ** rng.choice([-1, 0, 0, 1]))

    def box(z: float) -> Document:
        return {
            "shape": {"box": (size * rng.uniform(0.02, 0.3, size=3)).tolist()},
            "xyz": [0.0, 0.0, z],
            "rpy": [0.0] * 3,
        }

    links = [{"name": "base", "shapes": []}, {"name": "l0", "shapes": [box(0.1 * size)]}]
    joint = {"name": "j0", "type": "planar", "parent": "base", "child": "l0", "xyz": [0.0] * 3}
    joint |= {"rpy": [0.0] * 3, "axis": [0.0, 0.0, 1.0]}
    case: Document = {
        "kind": "checks",
        "robot": {"size": size, "links": links, "joints": [joint]},
        "objects": [],
    }
    for i in range(3):
        thing = box(0.1 * size)
        thing["xyz"][:2] = (0.6 * size * rng.normal(size=2)).tolist()
        thing["rpy"][2] = float(rng.uniform(-3, 3) * (rng.random() < 0.3))
        case["objects"].append({"name": f"o{i}", **thing})
    return _asked(rng, case, folder, reach=0.4)


def _asked(rng: np.random.Generator, case: Document, folder: Path, reach: float = 1.0) -> Document:
    """Return the case with instants of a motion, and a margin about the distance that there is."""
    size = case["robot"]["size"]
    read = Setting.lay_out(case, folder).robot
    motion = random_motion(rng, read.leaders, size=size, pieces=3, reach=reach)
    off = float(rng.choice([-1e-2, 1e-2, 1e-3, -1e-3, 0.1])) * size
    times = (rng.random(20) * motion["breaks"][-1]).tolist()
    case["questions"] = [{"motion": motion, "times": times, "off": off}]
    return case


def judge(case: Document, folder: Path) -> Outcome:
    """Ask about every configuration with a margin a little more or less than there is."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    stage = Stage.of(setting)
    look = Look(skip=declared(setting, stage))
    (question,) = case["questions"]
    curve = setting.curve(question["motion"])
    for time in question["times"]:
        pieces, local, _ = around(question["motion"], time, 0.0, 1)
        solids = stage.solids(positions(question["motion"], pieces, local), 1)
        last: Near | None = None
        for last in nearest(stage.pairs(solids, look), stage.size):  # noqa: B007
            pass
        if last is None or last.distance > 9.0:
            continue
        margin = max(0.0, last.distance + question["off"])
        rows = curve.positions(np.array([time]))
        (said,) = planning.check_configurations(setting.world, "r", rows, margin)
        outcome.count("asked")
        slack = _SLACK + _SHARE * stage.size
        if (
            last.distance > 0
            and said.nearest is not None
            and said.nearest.distance > last.distance + _TOLD * (1 + stage.size)
        ):
            told = f"nearest {said.nearest.distance:.9g} m, {last.pair} {last.distance:.9g} m"
            outcome.blame("check: distance", told, 9)
        own = stage.pairs(solids, Look(margin, look.skip))
        least = min(near.spare for near in nearest(own, stage.size))
        if said.valid and least < -slack:
            outcome.blame("check: valid", f"{-least:.6g} m less than the margin {margin:.6g} m", 9)
        if not said.valid and not said.limit_violations and least > slack:
            outcome.blame("check: invalid", f"{said.violations[0]}, but {least:.6g} m to spare", 9)
    return outcome
