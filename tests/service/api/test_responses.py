"""Results go out as the text that was recorded: what they say is what is declared, in pieces."""

import asyncio
import json

import pytest

from service.api import responses as whole_module
from service.api.models import ResponseModel
from service.api.responses import passed_on, whole
from service.jobs import json_steps
from service.jobs.job import JobSpec
from service.jobs.json_text import Encoded, encode
from service.jobs.store.sql.database import is_in_loop
from service.plans.models.plan import Plan
from service.plans.models.trajectory import Trajectory
from service.plans.tasks import PLAN
from service.regions.models import RegionsJob

# A megabyte, in steps of which it has hundreds.
STEP = 4096
POSITIONS = [[0.1 * i + j for j in range(7)] for i in range(8000)]
RESULT = {"result": {"positions": POSITIONS}, "polynomial": {"b": [1]}, "timings": {"total": 1.5}}


@pytest.fixture
def decoded_in_loop(monkeypatch):
    """How much was decoded at once by the thread of an event loop."""
    found = [0]
    loads = json.loads

    def listen(text, **options):
        if is_in_loop():
            found.append(len(text))
        return loads(text, **options)

    monkeypatch.setattr(json, "loads", listen)
    return found


@pytest.fixture(autouse=True)
def small_steps(monkeypatch):
    monkeypatch.setattr(json_steps, "STEP", STEP)
    monkeypatch.setattr(whole_module, "STEP", STEP)


def test_answers_are_what_is_declared(client, solved, few_regions):
    for answer, model in ((solved, Plan), (few_regions, RegionsJob)):
        kind = "plans" if model is Plan else "regions"
        again = client.get(f"/v1/{kind}/{answer['id']}").json()
        assert again == {**answer, "unrecorded": []}
        assert model.model_validate(again).model_dump(mode="json") == again
    trajectory = client.get(f"/v1/plans/{solved['id']}/trajectory?points=50").json()
    assert Trajectory.model_validate(trajectory).model_dump(mode="json") == trajectory


@pytest.fixture
def vast(app, client, solved):
    """The id of a plan with a large result, recorded as if a worker had just told it."""
    store = app.state.jobs._store
    payload = {"request": solved["request"], "revision": 1}
    job, _ = store.insert(JobSpec("plan", PLAN.name, payload, prefix="pln"))
    store.start(job.id)
    brief = {"timings": RESULT["timings"], "digest": "d"}
    store.succeed(job.id, Encoded(encode({**RESULT, "digest": "d"})), Encoded(encode(brief)))
    return job.id


def test_a_large_result_is_not_decoded_in_the_loop(client, vast, decoded_in_loop):
    answer = client.get(f"/v1/plans/{vast}")
    cancel = client.post(f"/v1/plans/{vast}/cancel")
    listed = client.get("/v1/plans?limit=1")
    assert max(decoded_in_loop) < 2 * STEP
    for told in (answer, cancel):
        assert told.headers["content-length"] == str(len(told.content)) > str(10**6)
        plan = told.json()
        assert plan["result"] == RESULT["result"]
        assert (plan["timings"], plan["digest"]) == (RESULT["timings"], "d")
    assert len(listed.content) < STEP * 2


class Brief(ResponseModel):
    id: str


async def pieces(response):
    if not hasattr(response, "body_iterator"):
        return [response.body]
    return [piece async for piece in response.body_iterator]


@pytest.mark.parametrize("count", [0, 1, 3, 8000])
def test_pieces_are_small_and_make_up_the_whole(count):
    async def story():
        content = {"result": POSITIONS[:count], "polynomial": "]{"}
        text = Encoded(encode(content))
        made = await pieces(await whole(Brief(id="x"), text))
        assert json.loads(b"".join(made)) == {"id": "x", "result": POSITIONS[:count]}
        passed = await pieces(passed_on(text))
        assert json.loads(b"".join(passed)) == content
        assert max(map(len, made + passed)) <= STEP + 100

    asyncio.run(story())


def test_what_has_no_result_says_so():
    async def story():
        for found in (None, Encoded('{"timings":{}}')):
            (body,) = await pieces(await whole(Brief(id="x"), found))
            assert json.loads(body) == {"id": "x", "result": None}

    asyncio.run(story())
