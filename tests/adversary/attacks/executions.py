"""Attack on executions: a proven plan of a scene that is not what it was when that was planned.

Another robot has moved into the way or is moving, the robot was put elsewhere, or it was given
something to hold that now collides. The motion must not be carried out.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tests.adversary.cases import Document, Outcome, Setting
from tests.adversary.draws.motions import positions, sample_places
from tests.adversary.draws.robots import random_robot
from tests.adversary.judge.delivered_motions import of_polynomial
from tests.adversary.judge.surroundings import Look, Stage
from tests.adversary.service import ask, post_scene

_DONE = "succeeded"
_FINAL = (_DONE, "failed", "canceled", "aborted")
# Where a robot counts as elsewhere [rad or m], and how deep a collision must be to be told [m].
_ELSEWHERE, _DEEP = 0.1, 1e-3
# Where what is given to the robot is held, in the frame of its last link [m].
_HELD_AT = (0.6, 0.0, 0.0)
_FAR = 6.0


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a robot with a motion, and a slide that can bring a box into its way."""
    robot = random_robot(
        rng,
        kinds=("revolute", "prismatic"),
        size=1.0,
        links=int(rng.integers(2, 4)),
        mimics=0.0,
        inertias=True,
    )
    robot["links"][-1]["shapes"] = [
        {"shape": {"box": [0.1, 0.1, 0.1]}, "xyz": [0.3, 0.0, 0.0], "rpy": [0.0] * 3}
    ]
    case: Document = {"kind": "executions", "robot": robot, "objects": []}
    read = Setting.lay_out(case, folder).robot
    ends = [
        {j.name: float(j.lower + (j.upper - j.lower) * rng.uniform(0.2, 0.8)) for j in read.leaders}
        for _ in range(2)
    ]
    middle = {name: (value + ends[1][name]) / 2 for name, value in ends[0].items()}
    case["positions"] = ends[0]
    case["others"] = [_slide(_last_link(read, middle) @ [0.3, 0.0, 0.0, 1.0])]
    attack = str(rng.choice(list(_ATTACKS)))
    case["questions"] = [{"attack": attack, "goal": ends[1], "middle": middle}]
    return case


def _last_link(robot: Any, at: Document) -> Any:
    placed = robot.place({n: np.array([[x]]) for n, x in at.items()}, np.eye(4), 1)
    return placed[robot.joints[-1].child][0]


def _slide(place: Any) -> Document:
    """Return a robot that can slide a box to a place, and is far from it."""
    box = {"shape": {"box": [0.1, 0.1, 0.1]}, "xyz": [0.0] * 3, "rpy": [0.0] * 3}
    joint = {"name": "j0", "type": "prismatic", "parent": "base", "child": "l0"}
    joint |= {"xyz": [0.0] * 3, "rpy": [0.0] * 3, "axis": [0.0, 0.0, 1.0]}
    joint |= {"lower": -1.0, "upper": _FAR + 1, "velocity": 3.0, "effort": 1e9}
    weight = {"mass": 1.0, "xyz": [0.0] * 3, "rpy": [0.0] * 3, "matrix": [0.1, 0, 0, 0.1, 0, 0.1]}
    links = [{"name": "base", "shapes": []}, {"name": "l0", "shapes": [box], "inertia": weight}]
    base = [[float(place[0]), float(place[1]), float(place[2]) - _FAR], [0.0] * 3]
    robot = {"size": 1.0, "links": links, "joints": [joint]}
    return {"name": "s", "robot": robot, "base": base, "positions": {"j0": 0.0}}


def judge(case: Document, folder: Path) -> Outcome:
    """Plan, change the scene, and try to carry the plan out."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    outcome.count("asked")
    scene = post_scene(setting.document, outcome)
    if scene is None:
        return outcome
    (question,) = case["questions"]
    names = [joint.name for joint in setting.group.joints]
    goal = [question["goal"][name.removeprefix("r::")] for name in names]
    plan = _plan(scene, "r", goal)
    if plan is None:
        outcome.count("no plan")
        return outcome
    _, exact = ask("GET", f"/v1/plans/{plan}/trajectory?polynomial=true", None)
    motion = of_polynomial(names, exact["polynomial"])
    found = _ATTACKS[question["attack"]](setting, scene, question, motion)
    outcome.count(question["attack"] if found else f"{question['attack']}: no harm in it")
    if found:
        status, _ = _carry_out(plan)
        if status < 300:
            outcome.blame("stale motion", f"{status}: {question['attack']}: {found}", 2)
    _end_all(scene)
    return outcome


def _plan(scene: str, group: str, goal: list[float]) -> str | None:
    body = {"scene": scene, "group": group, "goal": {"type": "joint", "positions": [goal]}}
    body |= {"search": {"allowed_planning_time": 2.0}, "refine": {"method": "none"}}
    _, job = ask("POST", "/v1/plans?wait=50", body)
    return job["id"] if job.get("state") == "succeeded" else None


def _carry_out(plan: str, speed: float = 100.0, wait: int = 0) -> tuple[int, Any]:
    body = {"plan": plan, "driver": "simulated", "speed": speed}
    return ask("POST", f"/v1/executions?wait={wait}", body)


def _end_all(scene: str) -> None:
    _, page = ask("GET", f"/v1/executions?scene={scene}", None)
    for job in page["items"]:
        if job["state"] not in _FINAL:
            ask("POST", f"/v1/executions/{job['id']}/cancel", None)


def _depth(setting: Setting, motion: Document, **more: Any) -> float:
    """Return how deep a motion collides in another scene [m]; negative if it does not."""
    changed = Setting.lay_out({**setting.case, **more}, setting.folder)
    look = Look(only=frozenset(["s::l0", "late", "given"]), count=80, rounds=1)
    seen = Stage.of(changed).worst(motion, look)
    return -np.inf if seen is None else -seen.distance


def _slid_in(setting: Setting, scene: str, _: Document, motion: Document) -> str | None:
    """The other robot has moved into the way, by an execution."""
    others = [{**setting.case["others"][0], "positions": {"j0": _FAR}}]
    depth = _depth(setting, motion, others=others)
    plan = _plan(scene, "s", [_FAR])
    if depth < _DEEP or plan is None:
        return None
    status, answer = _carry_out(plan, wait=50)
    if status >= 300 or answer["state"] != _DONE:
        return None
    return f"through the other robot, which has moved into the way, by {depth:.4g} m"


def _sliding(setting: Setting, scene: str, _: Document, __: Document) -> str | None:
    """The other robot is moving."""
    plan = _plan(scene, "s", [-0.5])
    status, answer = (400, None) if plan is None else _carry_out(plan, 0.05)
    if status >= 300:
        return None
    _, job = ask("GET", f"/v1/executions/{answer['id']}", None)
    return None if job["state"] in _FINAL else "while the other robot moves"


def _put_elsewhere(setting: Setting, scene: str, question: Document, _: Document) -> str | None:
    """The robot is no longer where the motion begins."""
    start, middle = setting.case["positions"], question["middle"]
    away = max(abs(middle[name] - value) for name, value in start.items())
    names = [joint.name.removeprefix("r::") for joint in setting.group.joints]
    values = [middle[name] for name in names]
    operation = {"op": "set_positions", "robot": "r", "positions": values}
    status, _ = ask("PATCH", f"/v1/scenes/{scene}", {"operations": [operation]})
    if status >= 300 or away < _ELSEWHERE:
        return None
    return f"{away:.4g} from where the robot is"


def _given(setting: Setting, scene: str, _: Document, motion: Document) -> str | None:
    """The robot holds something that it did not, which collides with what it alone passes by."""
    link = setting.robot.joints[-1].child
    pieces, local, _ = sample_places(motion, 41)
    half = len(local) // 2
    q = {name: rows[[half]] for name, rows in positions(motion, pieces, local).items()}
    place = setting.robot.place(q, np.eye(4), 1)[link][0] @ [*_HELD_AT, 1.0]
    held = {"name": "given", "shape": {"sphere": 0.05}, "xyz": list(_HELD_AT), "rpy": [0.0] * 3}
    late = {"name": "late", "shape": {"sphere": 0.02}, "rpy": [0.0] * 3}
    late["xyz"] = [float(x) for x in place[:3]]
    depth = _depth(setting, motion, objects=[late, {**held, "on": link}])
    operations: list[Document] = [
        {"op": "add", "object": _posted(late, {})},
        {"op": "add", "object": _posted(held, {"movable": True}, f"r::{link}")},
    ]
    status, _ = ask("PATCH", f"/v1/scenes/{scene}", {"operations": operations})
    if status >= 300 or depth < _DEEP:
        return None
    return f"with something in hand that collides by {depth:.4g} m"


def _posted(thing: Document, more: Document, frame: str = "") -> Document:
    entry = {"name": thing["name"], "shape": thing["shape"], "pose": {"position": thing["xyz"]}}
    return entry | more | ({"attached": {"frame": frame}} if frame else {})


_ATTACKS: dict[str, Callable[..., str | None]] = {
    "slid in": _slid_in,
    "sliding": _sliding,
    "put elsewhere": _put_elsewhere,
    "given": _given,
}
