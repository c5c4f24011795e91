"""Whether a robot may move is decided by where it is once nothing moves it."""

import asyncio
from types import SimpleNamespace

import pytest

from service.errors import RobotBusy, StartMismatch
from service.executions import submit
from service.executions.requests import ExecutionRequest
from service.jobs.errors import Overtaken
from service.jobs.job import JobSpec
from service.jobs.states import JobState
from service.jobs.store.entries import Entries, OpenEntry
from service.scenes.models.scene import SceneSummary
from service.scenes.models.summary import Group, Joint
from service.scenes.store.record_cache import Latest
from service.scenes.tasks import SceneWork

JOINT = Joint(name="arm::j", type="revolute")
MOVING = {
    "library": {"model_roots": [], "allow_paths": False},
    "scene": {"digest": "d", "document": "file"},
    "request": {"plan": "pln_1"},
    "scene_id": "s",
    "group": "arm",
    "speed": 1.0,
}
STILL = {
    "breaks": [0, 1],
    "bases": [[0]],
    "coefficients": [[[0]]],
    "joint_names": ["arm::j"],
    "joint_types": ["revolute"],
}


class Scene:
    """A scene, and jobs in it; executions of other servers enter it at moments that a test sets."""

    def __init__(self):
        self.positions = [0.0]
        self.latest = Latest()
        self.number = 0
        self.open = []
        self.while_looked_for = self.while_submitted = lambda: None

    def moved(self, *, to, is_over):
        """Have another execution begin, and end where it leads."""
        self.number += 1
        entry = OpenEntry(f"exe_{self.number}", self.number, frozenset({"arm"}), is_waiting=False)
        self.open = [] if is_over else [entry]
        self.positions = [to] if is_over else self.positions

    async def fresh(self, identifier):
        known = {"name": "arm", "aliases": [], "joints": [JOINT], "position_names": ["arm::j"]}
        group = Group.model_construct(**known, positions=self.positions)
        summary = SceneSummary.model_construct(groups=[group])
        known = {"digest": "d", "summary": summary, "live": {}, "revision": 1}
        return SimpleNamespace(id=identifier, document={"robots": []}, **known)

    async def job(self, queue, identifier, _=None):
        goal = {"type": "joint", "positions": [1.0]}
        request = {"scene": "s", "group": "arm", "goal": goal}
        payload = {**MOVING, "request": request, "revision": 1}
        result = {"start": [0.0], "path": [], "trajectory": {"positions": [[0.0], [1.0]]}}
        result["certificate"] = {"min_clearance": None}
        outcome = {"polynomial": STILL, "result": result}
        return SimpleNamespace(payload=payload, result=outcome, state=JobState.SUCCEEDED)

    async def open_job(self, queue, identifier):
        return SimpleNamespace(id=identifier, payload=MOVING)

    async def find_by_key(self, spec):
        return None

    async def entries(self, queue, scene):
        found = Entries(self.number, self.open)
        self.while_looked_for()
        return found

    def work(self, record):
        return SceneWork.model_validate({part: MOVING[part] for part in ("library", "scene")})

    async def submit(self, spec):
        before, self.while_submitted = self.while_submitted, lambda: None
        before()
        if self.number != spec.follows:
            raise Overtaken
        return spec


@pytest.fixture
def scene(monkeypatch):
    monkeypatch.setattr(submit, "spec_of", lambda *_, **__: JobSpec("execution", "", {}))
    return Scene()


def submitted(scene, **fields):
    terms = SimpleNamespace(jobs=scene, settings=SimpleNamespace(ur_hosts={}))
    request = ExecutionRequest(plan="pln_1", **fields)
    return asyncio.run(submit.submit_execution(request, None, scene, terms))


def test_a_motion_that_ends_while_it_is_looked_for_is_not_overlooked(scene):
    scene.while_looked_for = lambda: scene.moved(to=1.0, is_over=True)
    with pytest.raises(StartMismatch):
        submitted(scene)


def test_one_that_another_server_has_begun_is_in_the_way(scene):
    scene.while_submitted = lambda: scene.moved(to=1.0, is_over=False)
    with pytest.raises(RobotBusy) as refusal:
        submitted(scene)
    assert refusal.value.evidence == {"execution": "exe_1", "group": "arm"}


def test_one_that_another_server_has_begun_is_waited_for_on_request(scene):
    scene.while_submitted = lambda: scene.moved(to=1.0, is_over=False)
    spec = submitted(scene, when_busy="wait")
    assert (spec.waits, spec.follows, spec.robots) == (True, 1, ("arm",))


@pytest.mark.parametrize("to", [0.0, 1.0])
def test_after_one_that_began_and_ended_meanwhile_the_robot_is_looked_at_again(scene, to):
    scene.while_submitted = lambda: scene.moved(to=to, is_over=True)
    if to == 0.0:
        spec = submitted(scene)
        assert (spec.waits, spec.follows, spec.robots) == (False, 1, ("arm",))
    else:
        with pytest.raises(StartMismatch):
            submitted(scene)
