"""Attack on links that a joint joins: they swing into each other, and nothing else is near.

A pair may be left out of the proof only by evidence: its shapes touch about the joint, or never.
"""

from pathlib import Path

import numpy as np

from tests.adversary.cases import Document, Outcome, Setting
from tests.adversary.draws.motions import random_motion
from tests.adversary.draws.robots import SCALARS, random_robot
from tests.adversary.draws.shapes import random_shape
from tests.adversary.judge.clearance_judge import ClearanceJudge
from tests.adversary.judge.surroundings import Look, Stage
from tests.adversary.judge.unchecked_pairs import adjacent

_KINDS = (*SCALARS, *SCALARS, "planar")


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a robot of large links, and a motion on which, most often, neighbours collide."""
    for _ in range(8):
        case = _robot(rng)
        stage = Stage.of(Setting.lay_out(case, folder))
        motion = random_motion(rng, stage.robot.leaders, size=stage.size, reach=1.25)
        others = stage.worst(motion, Look(skip=adjacent(stage), count=40, rounds=0))
        near = stage.worst(motion, Look(count=40, rounds=0))
        if (others is None or others.spare > 0) and near is not None and near.spare < 0:
            break
    case["questions"] = [{"motion": motion, "margin": 0.0}]
    return case


def _robot(rng: np.random.Generator) -> Document:
    """Return a robot whose links are beside their joints, as likely near them as far from them."""
    links = int(rng.choice([1, 1, 2, 3]))
    robot = random_robot(rng, kinds=_KINDS, links=links, mimics=0.2)
    size = robot["size"]
    for link in robot["links"]:
        link["shapes"] = [
            {
                "shape": random_shape(rng, size * float(rng.uniform(0.2, 0.8))),
                "xyz": (size * float(rng.uniform(0.0, 0.7)) * rng.normal(size=3)).tolist(),
                "rpy": rng.uniform(-3, 3, size=3).tolist(),
            }
            for _ in range(int(rng.choice([1, 1, 2])))
        ]
    return {"kind": "neighbours", "robot": robot, "objects": []}


def judge(case: Document, folder: Path) -> Outcome:
    """Ask, and hold what is proven against all pairs, those that are left out too."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    stage = Stage.of(setting)
    for question in case["questions"]:
        answer = setting.ask(question)
        outcome.count("asked")
        if isinstance(answer, Exception):
            outcome.blame("error", f"{type(answer).__name__}: {answer}")
        else:
            ClearanceJudge(setting, stage, question, outcome).hold(*answer)
    return outcome
