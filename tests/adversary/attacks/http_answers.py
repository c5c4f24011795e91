"""Attack on what only the service says: columns by names, kept scenes, motions that are stale."""

from pathlib import Path
from typing import Any

import numpy as np

from service.scenes.world_cache import MAX_WORLDS
from tests.adversary.attacks.plans import straight
from tests.adversary.cases import Document, Outcome, Setting
from tests.adversary.draws.robots import random_robot
from tests.adversary.judge.kinematics import pose_matrix
from tests.adversary.judge.surroundings import Look, Stage
from tests.adversary.service import ask, post_scene

_ATTACKS = ("columns", "edited file", "new obstacle")


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a robot of at least two joints, a motion of it, and which attack it is for."""
    attack = str(rng.choice(_ATTACKS))
    links = int(rng.integers(2, 5))
    robot = random_robot(rng, kinds=("revolute", "prismatic"), size=1.0, links=links, mimics=0.0)
    robot["links"][-1]["shapes"] = [
        {"shape": {"box": [0.1, 0.1, 0.1]}, "xyz": [0.3, 0.0, 0.0], "rpy": [0.0] * 3}
    ]
    case: Document = {"kind": "http_answers", "attack": attack, "robot": robot, "objects": []}
    read = Setting.lay_out(case, folder).robot
    ends = [
        {j.name: float(j.lower + (j.upper - j.lower) * rng.uniform(0.2, 0.8)) for j in read.leaders}
        for _ in range(2)
    ]
    case["positions"] = ends[0]
    case["questions"] = [
        {"ends": ends, "order": [int(i) for i in rng.permutation(len(read.leaders))]}
    ]
    return case


def judge(case: Document, folder: Path) -> Outcome:
    """Carry the attack out."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    outcome.count("asked")
    scene = post_scene(setting.document, outcome)
    if scene is None:
        return outcome
    (question,) = case["questions"]
    attacks = {"columns": _columns, "edited file": _edited, "new obstacle": _obstructed}
    attacks[case["attack"]](setting, scene, question, outcome)
    return outcome


def _rows(setting: Setting, question: Document) -> tuple[list[str], np.ndarray]:
    names = [joint.name for joint in setting.group.joints]
    ends = [[end[name.removeprefix("r::")] for name in names] for end in question["ends"]]
    return names, np.array(ends)


def _certify(scene: str, trajectory: Document) -> Any:
    body = {"scene": scene, "group": "r", "trajectory": trajectory, "allowed_time": 60}
    status, answer = ask("POST", "/v1/trajectories/certify", body)
    return answer["certificate"] if status < 300 else None


def _columns(setting: Setting, scene: str, question: Document, outcome: Outcome) -> None:
    """Columns in another order, which `joint_names` tells, are the same motion."""
    names, (start, end) = _rows(setting, question)
    middle, speed = (start + end) / 2, (end - start) * np.linspace(0.02, 0.2, len(names))
    rows = np.stack([start, middle, end])
    rates = np.stack([0 * speed, speed, 0 * speed])
    told = {"times": [0.0, 3.0, 6.0]}
    plain = _certify(scene, {**told, "positions": rows.tolist(), "velocities": rates.tolist()})
    order = question["order"]
    turned = {"positions": rows[:, order].tolist(), "velocities": rates[:, order].tolist()}
    other = _certify(scene, {**told, **turned, "joint_names": [names[i] for i in order]})
    if other is None or plain is None:
        return
    both = [{c["name"]: c["value"] for c in answer["checks"]} for answer in (plain, other)]
    for rate in ("velocity", "acceleration"):
        if abs(both[0][rate] - both[1][rate]) > 1e-6 * max(1.0, abs(both[0][rate])):
            said = f"{rate} {both[1][rate]:.6g}, but {both[0][rate]:.6g} in the group's order"
            outcome.blame("columns", f"columns in the order {order}: {said}", 4)


def _edited(setting: Setting, scene: str, question: Document, outcome: Outcome) -> None:
    """After an edit an accepted scene stays, and one that is posted anew is what the file says."""
    _, rows = _rows(setting, question)
    motion = {"times": [0.0, 100.0], "positions": rows.tolist(), "velocities": (0 * rows).tolist()}
    before = _certify(scene, motion)
    case = {**setting.case, "robot": {**setting.case["robot"]}}
    case["robot"]["links"] = [dict(link) for link in case["robot"]["links"]]
    shapes = [{"shape": {"box": [9.0, 9.0, 9.0]}, "xyz": [0.0] * 3, "rpy": [0.0] * 3}]
    case["robot"]["links"][-1]["shapes"] = shapes
    case["objects"] = [
        {"name": "near", "shape": {"sphere": 0.05}, "xyz": [0.0] * 3, "rpy": [0.0] * 3}
    ]
    bare = {**case, "robot": setting.case["robot"]}
    first = Setting.lay_out(bare, setting.folder)
    _, posted = ask("POST", "/v1/scenes", first.document)
    old = _certify(posted["id"], motion)
    again = Setting.lay_out(case, setting.folder)
    _crowd_out()
    _, anew = ask("POST", "/v1/scenes", again.document)
    new = _certify(anew["id"], motion)
    kept = _certify(posted["id"], motion)
    seen = Stage.of(again).worst(straight(question["ends"], 100.0), Look(only=frozenset(["near"])))
    check = next(c for c in new["checks"] if c["name"] == "clearance") if new else None
    if check and check["passed"] and seen is not None and seen.distance < -1e-3:
        outcome.blame("edited file", f"proven with {seen.near.pair} {-seen.distance:.4g} m deep", 1)
    if old and kept and old != kept:
        outcome.blame("kept scene", "another answer of a scene whose file was edited", 1)
    outcome.count("proven before", bool(before and before["proven"]))


def _crowd_out() -> None:
    """Load so many other scenes that none of those before is still loaded."""
    for i in range(MAX_WORLDS):
        ask("POST", "/v1/scenes", {"name": f"other{i}", "robots": [{"name": "r", "model": "car"}]})


def _obstructed(setting: Setting, scene: str, question: Document, outcome: Outcome) -> None:
    """A motion is not carried out through what was put in its way since."""
    _, rows = _rows(setting, question)
    body = {
        "scene": scene,
        "group": "r",
        "goal": {"type": "joint", "positions": [rows[1].tolist()]},
    }
    body |= {"search": {"allowed_planning_time": 2.0}, "refine": {"method": "none"}}
    _, job = ask("POST", "/v1/plans?wait=50", body)
    if job.get("state") != "succeeded":
        outcome.count("no plan")
        return
    told = job["result"]["trajectory"]
    names = [joint.name.removeprefix("r::") for joint in setting.group.joints]
    middle = told["positions"][len(told["positions"]) // 2]
    placed = setting.robot.place(
        {n: np.array([[x]]) for n, x in zip(names, middle, strict=True)}, setting.base, 1
    )
    link = setting.case["robot"]["links"][-1]["name"]
    place = (placed[link][0] @ pose_matrix([0.3, 0.0, 0.0]))[:3, 3]
    thing = {"name": "late", "shape": {"sphere": 0.02}, "pose": {"position": place.tolist()}}
    ask("PATCH", f"/v1/scenes/{scene}", {"operations": [{"op": "add", "object": thing}]})
    status, answer = ask(
        "POST", "/v1/executions", {"plan": job["id"], "driver": "simulated", "speed": 1.0}
    )
    if status < 300:
        outcome.blame(
            "stale motion", f"{status}: carried out through an obstacle at {place.round(3)}", 2
        )
        ask("POST", f"/v1/executions/{answer['id']}/cancel", None)
