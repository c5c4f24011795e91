"""Whether a robot may move is decided by where it is once nothing moves it."""

import asyncio
from types import SimpleNamespace

import pytest

from service.errors import StartMismatch
from service.executions import submit as admission
from service.executions.models import ExecutionRequest
from service.scenes.models.scene import SceneSummary
from service.scenes.models.summary import Group, Joint
from service.scenes.record_cache import Latest

JOINT = Joint(name="arm::j", type="revolute")


class Moving:
    """A scene, and a desk: its robot ends its way from 0 to 1 while somebody looks for it."""

    def __init__(self):
        self.positions = [0.0]
        self.admitting_motion = asyncio.Lock()
        self.latest = Latest()

    async def fresh(self, identifier):
        known = {"name": "arm", "aliases": [], "joints": [JOINT], "position_names": ["arm::j"]}
        group = Group.model_construct(**known, positions=self.positions)
        summary = SceneSummary.model_construct(groups=[group])
        return SimpleNamespace(id=identifier, digest="d", summary=summary)

    async def job(self, lane, identifier):
        payload = {"request": {"scene": "s", "group": "arm"}, "scene": {"digest": "d"}}
        return SimpleNamespace(payload=payload, result={"result": {"start": [0.0]}})

    async def find_by_key(self, spec):
        return None

    async def in_scene(self, lane, scene):
        self.positions = [1.0]

    async def scene_payload(self, record):
        return {}

    async def submit(self, spec):
        return spec


def test_a_motion_that_ends_while_it_is_looked_for_is_not_overlooked(monkeypatch):
    monkeypatch.setattr(admission, "polynomial_of", lambda plan: {})
    moving = Moving()
    request = ExecutionRequest(plan="pln_1")
    with pytest.raises(StartMismatch):
        asyncio.run(admission.submit_execution(request, None, moving, moving))
