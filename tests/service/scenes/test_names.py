"""Names that do not exist: every field that names something says where, and what was meant."""

from collections.abc import Mapping
from typing import Annotated, TypeAliasType, get_args, get_origin

import pytest
from pydantic import BaseModel

from service.api.models import COORDINATES, Mark, Name
from service.api.names import mentions
from service.plans.models.request import PlanRequest
from service.queries.models.check import CheckRequest
from service.queries.models.kinematics import FkRequest, IkRequest
from service.queries.models.line import LineRequest
from service.regions.models import RegionsRequest
from service.trajectories.models import (
    CertifyMotionRequest,
    RetimeRequest,
    SpliceMotionRequest,
    StopMotionRequest,
)

REQUESTS = [
    PlanRequest,
    CheckRequest,
    FkRequest,
    IkRequest,
    LineRequest,
    RegionsRequest,
    RetimeRequest,
    CertifyMotionRequest,
    StopMotionRequest,
    SpliceMotionRequest,
]
# Names that are looked up elsewhere: of the group itself, of planners, of columns; and one that
# the client gives.
OTHERS = {"group", "planner", "parameters", "name", "joint_names", "joint_types", "velocity_names"}
OTHERS |= {"acceleration_bounds"}


def unmarked(annotation, seen):
    """The fields below a type that are names and say not of what."""
    if isinstance(annotation, TypeAliasType):
        annotation = annotation.__value__
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        if annotation in seen:
            return
        seen.add(annotation)
        for name, field in annotation.model_fields.items():
            if not any(isinstance(mark, Mark) for mark in field.metadata):
                if any(part is Name for part in bare(field.annotation)):
                    yield name
                yield from unmarked(field.annotation, seen)
        return
    for part in get_args(annotation):
        yield from unmarked(part, seen)


def bare(annotation):
    """The parts of a type that bear no mark, but for those of models in it."""
    yield annotation
    if annotation is Name:
        return
    if isinstance(annotation, TypeAliasType):
        yield from bare(annotation.__value__)
    if get_origin(annotation) is Annotated:
        marks = [mark for mark in annotation.__metadata__ if isinstance(mark, Mark)]
        if not marks:
            yield from bare(get_args(annotation)[0])
        return
    for part in get_args(annotation):
        yield from bare(part)


@pytest.mark.parametrize("request_model", REQUESTS)
def test_every_name_in_a_request_says_what_it_names(request_model):
    assert set(unmarked(request_model, set())) <= OTHERS


POSE = {"position": [0.4, 0.2, 0.3], "quaternion": [0, 1, 0, 0]}
Q = [0, -1.2, 1.9, -2.27, -1.57, 0]
BOX = {"size": [1, 1, 1], "pose": {**POSE, "frame": "abov"}}
PATH = [
    {"type": "distance_band", "bodies": ["blok"], "to": ["post", "blok"], "min": 0.01},
    {"type": "keep_out", "frame": "arm::tcq", "box": BOX},
    {
        "type": "position",
        "frame": "arm::tcq",
        "size": [None, None, 0.01],
        "pose": {**POSE, "frame": "abov"},
    },
    {"type": "locked_joints", "joints": ["arm::elbow_join"]},
    {"type": "joint_limits", "limits": {"arm::elbow_join": [0, 1]}},
]
LIMITS = {
    "tool_limits": [{"frame": "arm::tcq", "speed": 1}],
    "speed_zones": [{"name": "slow", "frame": "arm::tcq", "box": BOX, "speed": 1}],
    "payload": {"frame": "arm::tcq", "mass": 1},
}
SEARCH = {"weights": {"arm::elbow_join": 2}, "bounds": {"arm::elbow_join": [0, 1]}}
MOTION = {"times": [0, 1], "positions": [Q, Q], "velocities": [[0] * 6] * 2}
GOALS = [
    {"type": "pose", "poses": [POSE, {**POSE, "frame": "abov"}], "frame": "arm::tcq"},
    {"type": "pose", "poses": [POSE], "metric": {"tolerance": 1, "frame": "abov"}},
    {"type": "region", "pose": {**POSE, "frame": "abov"}, "frame": "arm::tcq"},
    {"type": "relative", "displacement": POSE, "reference": "abov"},
]
PLAN_GOALS = [
    *GOALS,
    {"type": "configuration", "name": "reddy"},
    {"type": "line", "displacement": {"vector": [0, 0, 1], "frame": "abov"}},
    {"type": "path", "poses": [{**POSE, "frame": "abov"}], "frame": "arm::tcq"},
]
WRONG = [
    *(("plans", {"goal": goal}) for goal in PLAN_GOALS),
    (
        "plans",
        {
            "goal": {"type": "joint", "positions": Q},
            "path_constraints": PATH,
            "retime": LIMITS,
            "search": SEARCH,
            "ik": {"joint_weights": {"arm::elbow_join": 1}},
        },
    ),
    *(("scenes/{}/ik", {"goal": goal, "path_constraints": PATH}) for goal in GOALS),
    ("scenes/{}/fk", {"configurations": [Q], "frames": ["arm::tcp", "abov"]}),
    ("scenes/{}/line", {"displacement": {"vector": [0, 0, 1]}, "frame": "arm::tcq"}),
    ("scenes/{}/line", {"pose": {**POSE, "frame": "abov"}}),
    ("scenes/{}/regions", {"bounds": {"arm::elbow_join": [0, 1]}}),
    ("trajectories/retime", {"waypoints": [Q, Q], "retime": LIMITS}),
    ("trajectories/certify", {"trajectory": MOTION, **LIMITS}),
    ("trajectories/stop", {"trajectory": MOTION, "time": 0, "path_constraints": PATH}),
    ("trajectories/splice", {"trajectory": MOTION, "onto": MOTION, "time": 0, **LIMITS}),
]
MEANT = {"abov": "above", "arm::tcq": "arm::tcp", "arm::elbow_join": "arm::elbow_joint"}
MEANT |= {"blok": "block", "reddy": "ready"}


def wrong_places(document, pointer=""):
    """The pointers to all names in a document that do not exist, with these names."""
    items = document.items() if isinstance(document, Mapping) else enumerate(document)
    for step, child in items:
        here = f"{pointer}/{step}"
        if step in MEANT:
            yield here, step
        if isinstance(child, str) and child in MEANT:
            yield here, child
        elif isinstance(child, Mapping | list):
            yield from wrong_places(child, here)


@pytest.mark.parametrize(("path", "body"), WRONG)
def test_all_wrong_names_are_told_with_their_places(client, scene, path, body):
    request = {"group": "arm", **body}
    if "{}" not in path:
        request["scene"] = scene
    answer = client.post(f"/v1/{path.format(scene)}", json=request)
    problem = answer.json()
    assert (answer.status_code, problem["code"]) == (422, "unknown_name"), problem
    told = {error["pointer"]: error for error in problem["errors"]}
    assert set(told) == dict(wrong_places(request)).keys()
    for pointer, name in wrong_places(request):
        assert told[pointer]["nearest"][0] == MEANT[name]
        assert repr(name) in told[pointer]["message"]
    assert problem["evidence"]["name"] in MEANT
    assert problem["evidence"]["nearest"][0] == MEANT[problem["evidence"]["name"]]


ELSEWHERE = [
    ("plans", {"search": {"planner": "RRTConect"}}, "/search/planner", "RRTConnect"),
    ("plans", {"search": {"planner": ["PRM", "RRTConect"]}}, "/search/planner/1", "RRTConnect"),
    ("plans", {"search": {"parameters": {"rnge": 1}}}, "/search/parameters/rnge", "range"),
    ("plans", {"group": "amr"}, "/group", "arm"),
    (
        "plans",
        {"retime": {"acceleration_bounds": {"arm::elbow_join": [-1, 1]}}},
        "/retime/acceleration_bounds/arm::elbow_join",
        "arm::elbow_joint",
    ),
    (
        "trajectories/certify",
        {"trajectory": {**MOTION, "joint_names": ["arm::elbow_join"] * 6}},
        "/trajectory/joint_names/0",
        "arm::elbow_joint",
    ),
]


@pytest.mark.parametrize(("path", "change", "pointer", "meant"), ELSEWHERE)
def test_names_that_are_looked_up_elsewhere_have_their_places_too(
    client, scene, path, change, pointer, meant
):
    goal = {"goal": {"type": "joint", "positions": Q}} if path == "plans" else {}
    request = {"scene": scene, "group": "arm", **goal, **change}
    answer = client.post(f"/v1/{path}", json=request)
    assert (answer.status_code, answer.json()["code"]) == (422, "unknown_name")
    (error,) = answer.json()["errors"]
    assert error["pointer"] == pointer
    assert error["nearest"][0] == meant


def test_an_edit_says_which_operation_names_what_is_not_there(client, scene):
    first = {"op": "allow", "pair": ["block", "post"]}
    wrong = {"op": "allow", "pair": ["block", "pots"]}
    answer = client.patch(f"/v1/scenes/{scene}", json={"operations": [first, wrong]})
    (error,) = answer.json()["errors"]
    assert answer.status_code == 422
    assert error["pointer"] == "/operations/1/pair/1"
    assert error["nearest"] == ["post"]


@pytest.mark.parametrize("media", ["json", "yaml"])
def test_a_posted_scene_says_where_it_names_what_does_not_exist(client, media):
    content = "{name: ur5f, robots: [{name: ur5f, model: ur5e}, {name: b, model: ur5f}]}"
    if media == "json":
        content = '{"robots": [{"name": "ur5f", "model": "ur5e"}, {"name": "b", "model": "ur5f"}]}'
    headers = {"content-type": f"application/{media}"}
    answer = client.post("/v1/scenes", content=content, headers=headers)
    assert (answer.status_code, answer.json()["code"]) == (422, "unknown_name")
    (error,) = answer.json()["errors"]
    assert error["pointer"] == "/robots/1/model"
    assert "ur5e" in error["nearest"]


def test_a_wrong_count_says_where(client, scene):
    goal = {"type": "joint", "positions": [Q, [0.0]]}
    answer = client.post("/v1/plans", json={"scene": scene, "group": "arm", "goal": goal})
    assert (answer.status_code, answer.json()["code"]) == (409, "wrong_joint_count")
    assert answer.json()["errors"][0]["pointer"] == "/goal/positions/1"
    assert answer.json()["evidence"]["field"] == "goal.positions.1"


def test_many_wrong_names_are_not_all_told(client, scene):
    body = {"group": "arm", "configurations": [Q], "frames": ["abov"] * 500}
    problem = client.post(f"/v1/scenes/{scene}/fk", json=body).json()
    assert len(problem["errors"]) == 20
    assert "499 more" in problem["detail"]


def test_values_without_marks_are_not_looked_at():
    """Of ten thousand configurations no number is visited, only each row."""
    rows = [[float(i)] * 6 for i in range(50)]
    request = CheckRequest(group="arm", configurations=rows)
    found = list(mentions(request))
    assert [one.value for one in found] == rows
    assert {one.kind for one in found} == {COORDINATES}
