"""What a task returned is one text; what is large in it is found there without reading the rest."""

import json

import pytest
from pydantic import BaseModel, JsonValue, RootModel

from service.jobs import task
from service.jobs.json_steps import member_of
from service.jobs.outline import Outline
from service.jobs.task import Task, UnknownTask
from service.jobs.worker.protocol import MessageKind, load_error
from service.jobs.worker.run_task import run_task


class Found(BaseModel):
    result: dict[str, JsonValue]
    timings: dict[str, float] = {}
    graph: JsonValue = None


CONTENTS = [
    {"result": {"times": [0.1, 2.0], "name": "a\n"}, "timings": {"load": 0.5}, "graph": [1]},
    {"result": {"times": []}, "timings": {}, "graph": None},
]


@pytest.fixture
def declared(monkeypatch):
    """Declares tasks for this test alone."""
    monkeypatch.setattr(task, "_tasks", {})
    return Task


@pytest.mark.parametrize("content", CONTENTS)
def test_large_members_have_lines_of_their_own(declared, content):
    large = Outline(result=("result.times", "graph"))
    declared("echo", Found, Found, outline=large).runs(lambda work, _: work)
    end = run_task("echo", json.dumps(content), None)
    assert end.kind is MessageKind.RESULT, end.text
    assert json.loads(end.text) == content
    assert json.loads(member_of(end.text, "result")) == content["result"]
    _, *lines = end.text.splitlines()
    assert [line.partition(":")[0] for line in lines] == ['"result"', '"graph"']
    kept = {name: item for name, item in content["result"].items() if name != "times"}
    assert json.loads(end.summary) == {"result": kept, "timings": content["timings"]}


def test_what_has_nothing_large_is_one_line_and_its_own_summary(declared):
    declared("echo", Found, Found).runs(lambda work, _: work)
    end = run_task("echo", json.dumps(CONTENTS[0]), None)
    assert (json.loads(end.text), end.summary) == (CONTENTS[0], "")
    assert "\n" not in end.text


@pytest.mark.parametrize(
    "name", ["planning:plan", "service.plans.worker:plan_motion", "os:getcwd", "nothing"]
)
def test_no_function_is_called_by_its_path(declared, name):
    declared("echo", Found, Found)
    assert task.outline_of(name) == Outline()
    with pytest.raises(UnknownTask, match="echo"):
        task.task_named(name)
    end = run_task(name, "{}", None)
    assert end.kind is MessageKind.FAILURE
    assert load_error(end.text).evidence["exception"] == "UnknownTask"


def test_a_task_that_no_module_carries_out_is_told(declared):
    declared("idle", Found, RootModel[JsonValue])
    with pytest.raises(UnknownTask, match="idle"):
        task.task_named("idle").run("{}", None)
