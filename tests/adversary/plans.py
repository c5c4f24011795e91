"""Attack on whole plans: what plan() delivers, with things in hand, and the samples of it.

The plan is asked of the service, over HTTP and in this process. Its exact motion must keep what its
certificate says, and so must its samples, as a receiver reads them: straight lines, or polynomials
of degree 5 through positions, velocities and accelerations.
"""

from pathlib import Path
from typing import Any

import numpy as np

from tests.adversary.cases import Document, Outcome, Setting
from tests.adversary.clearance import held_thing
from tests.adversary.clearance_judge import SHARE, SLACK, ClearanceJudge
from tests.adversary.motions import hermite
from tests.adversary.obstacles import random_obstacle
from tests.adversary.peaks import ORDERS, all_peaks, all_ranges
from tests.adversary.robots import SCALARS, random_robot
from tests.adversary.service import ask
from tests.adversary.surroundings import Look, Stage
from tests.adversary.unlooked import declared

# Rates of samples are read with rounding in them.
_RATE = 1e-3


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
    status, scene = ask("POST", "/v1/scenes", setting.document)
    if status >= 300:
        outcome.blame("error", f"{status}: {scene.get('detail')}")
        return outcome
    (question,) = case["questions"]
    names = [joint.name for joint in setting.group.joints]
    goal = [question["goal"][name.removeprefix("r::")] for name in names]
    body = {
        "scene": scene["id"],
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
    motion = _of_polynomial(names, exact["polynomial"])
    _hold(outcome, setting, stage, ("plan", 0), motion)
    answer = setting.ask({"motion": motion, "options": {"method": question["retime"]["method"]}})
    if isinstance(answer, Exception) or not answer[0].proven:
        outcome.blame("plan", f"delivered, and not proven again: {answer}")
    else:
        ClearanceJudge(setting, stage, {"motion": motion}, outcome).hold(*answer)
    for kind, read in _readings(names, job["result"]["trajectory"]).items():
        _hold(outcome, setting, stage, (f"samples, {kind}", 3), read)
    return outcome


def _of_polynomial(names: list[str], polynomial: Document) -> Document:
    bases, powers = np.array(polynomial["bases"]), np.array(polynomial["coefficients"])
    parts = {
        name.removeprefix("r::"): {
            "bases": bases[:, [i]].tolist(),
            "coefficients": powers[:, :, [i]].tolist(),
        }
        for i, name in enumerate(names)
    }
    return {"breaks": polynomial["breaks"], "joints": parts}


def _readings(names: list[str], told: Document) -> dict[str, Document]:
    """Return the motions that samples stand for, of the readings that are said to be proven."""
    proven = {"linear": True, "quintic": True}
    for entry in told.get("interpolations") or []:
        proven[entry["kind"]] = entry["proven"]
    return {kind: _read(names, told, kind) for kind in ("linear", "quintic") if proven[kind]}


def _read(names: list[str], told: Document, kind: str) -> Document:
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
                pieces.append(hermite(h, step, v[two][:, [i]], a[two][:, [i]]).tolist())
        parts[name.removeprefix("r::")] = {"bases": p[:-1, [i]].tolist(), "coefficients": pieces}
    return {"breaks": times.tolist(), "joints": parts}


def _hold(
    outcome: Outcome, setting: Setting, stage: Stage, what: tuple[str, int], motion: Document
) -> None:
    """Hold a motion against limits as the file has them, and against obstacles."""
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
