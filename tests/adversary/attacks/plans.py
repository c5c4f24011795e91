"""Attack on whole plans: what plan() delivers, with things in hand, and the samples of it.

The plan is asked of the service, over HTTP and in this process. Its exact motion must keep what its
certificate says, and so must its samples, as a receiver reads them: straight lines, or polynomials
of degree 5 through positions, velocities and accelerations.
"""

from pathlib import Path
from typing import Any

import numpy as np

from tests.adversary.attacks.clearance import held_thing
from tests.adversary.cases import Document, Outcome, Setting
from tests.adversary.draws.motions import hermite
from tests.adversary.draws.obstacles import random_obstacle
from tests.adversary.draws.robots import SCALARS, random_robot
from tests.adversary.judge.clearance_judge import ClearanceJudge
from tests.adversary.judge.delivered_motions import hold_delivered, of_polynomial, read_samples
from tests.adversary.judge.surroundings import Stage
from tests.adversary.service import ask, post_scene


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a robot that shall go from one configuration to another, past obstacles."""
    size = float(rng.choice([0.3, 1.0, 1.0, 3.0]))
    robot = random_robot(rng, kinds=(*SCALARS, "fixed"), size=size, mimics=0.2)
    case: Document = {"kind": "plans", "robot": robot, "objects": []}
    if rng.random() < 0.4:
        case["objects"].append(held_thing(rng, robot))
    read = Setting.lay_out(case, folder).robot
    ends = [{j.name: _somewhere(rng, j) for j in read.leaders} for _ in range(2)]
    stage = Stage(read, case, np.eye(4), {})
    direct = straight(ends)
    for i in range(int(rng.integers(0, 3))):
        case["objects"].append(random_obstacle(rng, stage, direct, f"o{i}"))
        stage.add(case["objects"][-1])
    case["positions"] = ends[0]
    method = str(rng.choice(["toppra", "ruckig"]))
    sampling = [{}, {}, {"num_points": 2}, {"sample_period": 0.2}, {"num_points": 9}]
    chosen = dict(sampling[int(rng.integers(len(sampling)))])
    case["questions"] = [
        {"goal": ends[1], "retime": {"method": method, **chosen}, "seed": int(rng.integers(100))}
    ]
    return case


def _somewhere(rng: np.random.Generator, joint: Any) -> float:
    low, high = (joint.lower, joint.upper) if np.isfinite(joint.lower) else (-3.0, 3.0)
    return float((low + high) / 2 + 0.4 * (high - low) * rng.uniform(-1, 1))


def straight(ends: list[Document], duration: float = 1.0) -> Document:
    """Return the motion from the one configuration to the other, from rest to rest."""
    zero = np.zeros((2, 1))
    parts = {
        name: {
            "bases": [[start]],
            "coefficients": [
                hermite(duration, np.array([ends[1][name] - start]), zero, zero).tolist()
            ],
        }
        for name, start in ends[0].items()
    }
    return {"breaks": [0.0, duration], "joints": parts}


def judge(case: Document, folder: Path) -> Outcome:
    """Plan, and hold the motion and its samples against the judge's own."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    stage = Stage.of(setting)
    outcome.count("asked")
    scene = post_scene(setting.document, outcome)
    if scene is None:
        return outcome
    (question,) = case["questions"]
    names = [joint.name for joint in setting.group.joints]
    goal = [question["goal"][name.removeprefix("r::")] for name in names]
    body = {
        "scene": scene,
        "group": "r",
        "goal": {"type": "joint", "positions": [goal]},
        "retime": question["retime"],
        "seed": question["seed"],
        "search": {"allowed_planning_time": 2.0},
    }
    status, job = ask("POST", "/v1/plans?wait=50", body)
    if status >= 300:
        outcome.blame("error", f"{status}: {job}")
        return outcome
    if job["state"] != "succeeded":
        failure = job["failure"]["code"]
        outcome.count(f"no plan: {failure}")
        return outcome
    outcome.count("planned")
    _, exact = ask("GET", f"/v1/plans/{job['id']}/trajectory?polynomial=true", None)
    motion = of_polynomial(names, exact["polynomial"])
    hold_delivered(outcome, setting, stage, ("plan", 0), motion)
    answer = setting.ask({"motion": motion, "options": {"method": question["retime"]["method"]}})
    if isinstance(answer, Exception) or not answer[0].proven:
        outcome.blame("plan", f"delivered, and not proven again: {answer}")
    else:
        ClearanceJudge(setting, stage, {"motion": motion}, outcome).hold(*answer)
    for kind, read in _readings(names, job["result"]["trajectory"]).items():
        hold_delivered(outcome, setting, stage, (f"samples, {kind}", 3), read)
    return outcome


def _readings(names: list[str], told: Document) -> dict[str, Document]:
    """Return the motions that samples stand for, of the readings that are said to be proven."""
    proven = {"linear": True, "quintic": True}
    for entry in told.get("interpolations") or []:
        proven[entry["kind"]] = entry["proven"]
    return {kind: read_samples(names, told, kind) for kind in ("linear", "quintic") if proven[kind]}
