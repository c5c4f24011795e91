"""The rule of the live state against a small model of it, over random sequences of changes."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tests.profiles import PROFILE, num_cases, only_campaign
from tests.service.live.test_state import CELL, edited, moved, posted, whole

ROBOTS = [robot["name"] for robot in CELL["robots"]]
BASES = {
    robot["name"]: np.array(robot.get("base", {"position": [0, 0, 0]})["position"][:2], float)
    for robot in CELL["robots"]
}
PLACES = st.tuples(
    st.sampled_from([-0.4, -0.1, 0.2]), st.sampled_from([-0.3, -0.25]), st.sampled_from([0.0, 0.2])
).map(list)
STEPS = st.one_of(
    st.tuples(st.just("execute"), st.sampled_from(ROBOTS), PLACES),
    st.tuples(st.just("set"), st.sampled_from(ROBOTS), PLACES),
    st.tuples(st.just("attach"), st.sampled_from(ROBOTS), st.none()),
    st.tuples(st.just("obstacle"), st.none(), st.none()),
    st.tuples(st.just("detach"), st.none(), st.none()),
)
RULES = settings(
    max_examples=num_cases(5, 40),
    deadline=None,
    derandomize=not PROFILE.is_campaign,
    database=None,
    suppress_health_check=list(HealthCheck),
)


@dataclass
class Model:
    """What the rule says: robots and the post, one revision after the other.

    `held` is the robot that holds the post, and p_BP, where in its body.
    """

    live: dict = field(default_factory=lambda: {r["name"]: r["positions"] for r in CELL["robots"]})
    source: dict = field(default_factory=dict)
    described: list = field(default_factory=list)
    post: np.ndarray = field(default_factory=lambda: np.array([2.0, 2.0]))
    held: tuple | None = None

    def __post_init__(self):
        self.described.append(dict(self.live))

    @property
    def revision(self):
        return len(self.described)

    def revise(self, **changes):
        self.described.append({**self.described[-1], **changes})

    def frame(self, robot):
        """R and p of a robot's body in the plane of the world."""
        x, y, yaw = self.live[robot]
        c, s = math.cos(yaw), math.sin(yaw)
        return np.array([[c, -s], [s, c]]), BASES[robot] + [x, y]

    def post_in_world(self):
        if self.held is None:
            return self.post
        robot, p_BP = self.held
        R, p = self.frame(robot)
        return R @ p_BP + p

    def place(self, robot, q, source):
        self.live[robot], self.source[robot] = q, source


def step(client, scene, model, kind, robot, place):
    """Do a step to the scene and to the model of it."""
    match kind:
        case "execute":
            execution, measured = moved(client, scene, place, robot)
            model.place(robot, measured, {"type": "execution", "id": execution})
        case "set":
            edited(client, scene, {"op": "set_positions", "robot": robot, "positions": place})
            model.revise(**{robot: place})
            model.place(robot, place, {"type": "edit", "revision": model.revision})
        case "obstacle":
            new = {"name": f"new{model.revision}", "shape": {"sphere": 0.1}}
            new["pose"] = {"position": [9, model.revision, 0]}
            edited(client, scene, {"op": "add", "object": new})
            model.revise()
        case "attach" if model.held is None:
            edited(client, scene, {"op": "attach", "object": "post", "frame": f"{robot}::body"})
            R, p = model.frame(robot)
            model.held = robot, R.T @ (model.post - p)
            model.revise()
        case "detach" if model.held is not None:
            edited(client, scene, {"op": "detach", "object": "post"})
            model.post, model.held = model.post_in_world(), None
            model.revise()


def check(client, scene, model):
    told = whole(client, scene)
    assert told["revision"] == model.revision
    held = [] if model.held is None else [("post", f"{model.held[0]}::body")]
    assert [(each["object"], each["frame"]) for each in told["attached"]] == held
    shown = client.get(f"/v1/scenes/{scene}").json()
    for robot, group in zip(told["robots"], shown["groups"], strict=True):
        name = robot["robot"]
        assert robot["positions"] == {"base_joint": model.live[name]}
        assert group["positions"] == model.live[name]
        first = {"type": "document", "revision": model.revision}
        assert robot["source"] == model.source.get(name, first)
        assert (robot["status"], robot["execution"]) == ("at_rest", None)
    for revision, positions in enumerate(model.described, 1):
        old = client.get(f"/v1/scenes/{scene}?revision={revision}").json()
        assert {g["name"]: g["positions"] for g in old["groups"]} == positions
    asked = {"group": "body", "configurations": [model.live["body"]], "frames": ["post"]}
    answer = client.post(f"/v1/scenes/{scene}/fk", json=asked)
    assert answer.status_code == 200, answer.text
    post = answer.json()["results"][0]["post"]["position"][:2]
    assert post == pytest.approx(model.post_in_world(), abs=1e-9)


@only_campaign("9 s")
@RULES
@example(
    steps=[
        ("execute", "body", [-0.1, -0.3, 0.2]),
        ("attach", "body", None),
        ("obstacle", None, None),
        ("execute", "body", [0.2, -0.3, 0.0]),
        ("detach", None, None),
        ("set", "body", [-0.4, -0.3, 0.0]),
    ]
)
@given(steps=st.lists(STEPS, min_size=2, max_size=7))
def test_the_state_is_the_latest_revision_and_what_was_measured_since(client, steps):
    scene, model = posted(client, CELL), Model()
    check(client, scene, model)
    for each in steps:
        step(client, scene, model, *each)
        check(client, scene, model)
