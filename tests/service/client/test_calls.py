"""What clients do with answers: refusals, streams that break, jobs that take long."""

import asyncio
import itertools
import json
import subprocess
import sys

import httpx
import numpy as np
import pytest

from wayproof_client import (
    ApiError,
    AsyncClient,
    Client,
    JobFailed,
    NotModified,
    WaitTimeout,
    models,
)
from wayproof_client.call import Call

URL = "http://localhost"
FAILURE = {"code": "goal_unreachable", "stage": "goals", "detail": "too far", "evidence": {}}


def client_of(answer, kind):
    """A client of a server that answers by a function of the request, and takes no time."""

    async def later(request):
        return answer(request)

    if kind == "sync":
        made = Client(URL, key="secret", transport=httpx.MockTransport(answer))
        made._pause = lambda _: None
        return made
    made = AsyncClient(URL, key="secret", transport=httpx.MockTransport(later))
    made._pause = lambda _: asyncio.sleep(0)
    return made


def result(answer):
    """What a call returns or yields, whether awaited or not."""

    async def gathered():
        return [one async for one in answer]

    async def awaited():
        return await answer

    if hasattr(answer, "__aiter__"):
        return asyncio.run(gathered())
    if hasattr(answer, "__await__"):
        return asyncio.run(awaited())
    return list(answer) if hasattr(answer, "__next__") else answer


def problem(code, evidence, status=404):
    said = {"type": "urn:x", "title": "t", "status": status, "code": code, "detail": "no such"}
    return said | {"evidence": evidence}


both = pytest.mark.parametrize("kind", ["sync", "async"])


@both
def test_a_refusal_has_the_class_of_its_code(kind, client):
    told = client.get("/v1/plans/pln_nothing")
    answer = httpx.Response(
        404, content=told.content, headers={"X-Request-ID": "r1", "Retry-After": "3"}
    )
    with pytest.raises(ApiError) as refusal:
        result(client_of(lambda _: answer, kind).get_plan("pln_nothing"))
    assert isinstance(refusal.value.problem, models.NotFoundProblem)
    assert refusal.value.code == "not_found"
    assert (refusal.value.request_id, refusal.value.retry_after) == ("r1", 3.0)


@both
def test_a_refusal_of_a_newer_server_and_one_of_a_proxy_are_kept(kind):
    news = httpx.Response(418, json=problem("teapot", {"spout": [1]}, 418))
    with pytest.raises(ApiError, match="418 teapot") as refusal:
        result(client_of(lambda _: news, kind).get_health())
    assert isinstance(refusal.value.problem, models.OtherProblem)
    assert refusal.value.problem.evidence == {"spout": [1]}
    with pytest.raises(ApiError, match="502 http_error: <html>"):
        result(client_of(lambda _: httpx.Response(502, text="<html>"), kind).get_health())


@both
def test_a_scene_that_has_not_changed_is_no_scene(kind):
    asked = client_of(lambda _: httpx.Response(304), kind)
    with pytest.raises(NotModified):
        result(asked.get_scene("scn_1", if_none_match='"1"'))


@both
def test_the_key_goes_with_every_request_and_a_long_wait_is_waited_for(kind, solved):
    seen = []

    def answer(request):
        seen.append(request)
        return httpx.Response(200, json=solved)

    result(client_of(answer, kind).create_plan({}, wait=3000))
    assert seen[0].headers["authorization"] == "Bearer secret"
    assert seen[0].extensions["timeout"]["read"] > 3000


def stream(*ids):
    """The text of a stream of progress."""
    at = "2026-01-01T00:00:00Z"
    data = {"at": at, "stage": "search", "progress": 0.5, "detail": ""}
    return "".join(f"id: {i}\nevent: progress\ndata: {json.dumps(data)}\n\n" for i in ids)


class Breaking(httpx.SyncByteStream, httpx.AsyncByteStream):
    """A body that ends before it is whole."""

    def __init__(self, text):
        self.text = text.encode()

    def __iter__(self):
        yield self.text
        raise httpx.ReadError("gone")

    async def __aiter__(self):
        yield self.text
        raise httpx.ReadError("gone")


@both
def test_a_stream_that_breaks_goes_on_where_it_was(kind):
    seen = []

    def answer(request):
        seen.append(request.headers.get("Last-Event-ID"))
        headers = {"content-type": "text/event-stream"}
        if len(seen) < 3:
            text = stream(2 * len(seen) - 1, 2 * len(seen))
            return httpx.Response(200, headers=headers, stream=Breaking(text))
        return httpx.Response(200, headers=headers, text=stream(5))

    events = result(client_of(answer, kind).stream_plan_events("pln_1"))
    assert [event.id for event in events] == ["1", "2", "3", "4", "5"]
    assert seen == [None, "2", "4"]
    assert isinstance(events[0], models.ProgressEvent)
    assert events[0].data.stage == "search"


@both
def test_a_stream_that_never_comes_back_is_an_error(kind):
    tries = itertools.count()

    def answer(_):
        next(tries)
        raise httpx.ConnectError("nothing there")

    with pytest.raises(httpx.ConnectError):
        result(client_of(answer, kind).stream_plan_events("pln_1"))
    assert next(tries) == 6


@both
def test_a_wait_ends_with_the_job(kind, solved):
    looks = itertools.count(1)

    def answer(_):
        is_over = next(looks) > 3
        return httpx.Response(200, json=solved if is_over else running(solved))

    plan = models.Plan.model_validate(running(solved))
    assert result(client_of(answer, kind).wait(plan)).result.digest == solved["digest"]
    assert next(looks) == 5


@both
def test_a_wait_for_a_job_without_a_result_says_why(kind, solved):
    failed = solved | {"state": "failed", "result": None, "failure": FAILURE}
    answer = httpx.Response(200, json=failed)
    asked = client_of(lambda _: answer, kind)
    plan = models.Plan.model_validate(running(solved))
    with pytest.raises(JobFailed, match="goal_unreachable: too far") as ended:
        result(asked.wait(plan))
    assert ended.value.code == "goal_unreachable"
    assert ended.value.job.id == solved["id"]
    assert result(asked.wait(plan, check=False)).state == "failed"


@both
def test_a_wait_has_an_end(kind, solved):
    asked = client_of(lambda _: httpx.Response(200, json=running(solved)), kind)
    plan = models.Plan.model_validate(running(solved))
    with pytest.raises(WaitTimeout, match="0 s") as ended:
        result(asked.wait(plan, timeout=0.0))
    assert ended.value.job == plan


def running(solved):
    return solved | {"state": "running", "finished_at": None, "result": None}


@both
def test_what_is_no_job_is_not_waited_for(kind):
    asked = client_of(lambda _: httpx.Response(200), kind)
    with pytest.raises(TypeError, match="Health is no job"):
        result(asked.refresh(models.Health.model_construct(status="ok")))


def test_bodies_may_have_arrays_and_models_but_no_infinity(solved):
    request = models.Plan.model_validate(solved).request
    body = {"scene": "s", "start": np.arange(2.0), "count": np.int64(3), "goal": request.goal}
    sent = json.loads(Call("POST", "/", body=body).request()["content"])
    assert sent["start"] == [0.0, 1.0]
    assert sent["count"] == 3
    assert sent["goal"] == {"type": "configuration", "name": "ready"}
    assert json.loads(Call("POST", "/", body=request).request()["content"])["seed"] == 3
    with pytest.raises(ValueError, match="not JSON compliant"):
        Call("POST", "/", body={"x": float("inf")}).request()
    with pytest.raises(TypeError, match="object is no JSON"):
        Call("POST", "/", body={"x": object()}).request()


def test_a_plan_shows_itself_with_replay_and_plots(solved):
    def answer(request):
        path = request.url.path
        if path.endswith("replay.html"):
            return httpx.Response(200, text='<p title="it&apos;s">moves</p>')
        if "/plots/" in path:
            return httpx.Response(200, text=f"<svg>{path}</svg>")
        return httpx.Response(200, json=solved)

    plan = client_of(answer, "sync").get_plan(solved["id"])
    page = plan._repr_html_()
    assert page.count("<img") == 4
    assert 'sandbox="allow-scripts"' in page
    assert "&lt;p title=&quot;it&amp;apos;s&quot;&gt;moves" in page
    assert result(client_of(answer, "async").view(plan)).html == page
    unbound = models.Plan.model_validate(solved)
    assert "<iframe" not in unbound._repr_html_()
    assert "proven" in unbound._repr_html_()
    assert unbound == plan


def test_a_plan_that_failed_says_so_without_asking(solved):
    failure = FAILURE | {"detail": "<b>too far</b>"}
    failed = solved | {"state": "failed", "result": None, "failure": failure}
    page = models.Plan.model_validate(failed)._repr_html_()
    assert "&lt;b&gt;too far" in page
    assert "goal_unreachable" in page


def test_the_package_needs_nothing_of_the_service():
    program = "import sys, wayproof_client; print(*{name.split('.')[0] for name in sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert {"service", "planning", "pydrake", "numpy"}.isdisjoint(done.stdout.split())
    assert "httpx" in done.stdout.split()
