"""What a task returned is one text; what is large in it is found there without reading the rest."""

import json

import pytest

from service.jobs import outline, task
from service.jobs.json_steps import member_of
from service.jobs.worker.protocol import MessageKind

ECHO = f"{__name__}:echo"
CONTENTS = [
    {"result": {"times": [0.1, 2.0], "name": "a\n"}, "timings": {"load": 0.5}, "graph": None},
    {"result": {"times": []}},
    {"timings": {}},
    [1, 2],
    None,
]


def echo(payload, _):
    return payload


@pytest.mark.parametrize("content", CONTENTS)
def test_large_members_have_lines_of_their_own(monkeypatch, content):
    large = outline.Outline(result=("result.regions", "graph"))
    monkeypatch.setattr(task, "outline_of", lambda _: large)
    end = task.run_task(ECHO, json.dumps(content), None)
    assert end.kind is MessageKind.RESULT
    assert json.loads(end.text) == content
    if isinstance(content, dict) and "result" in content:
        assert json.loads(member_of(end.text, "result")) == content["result"]
    _, *lines = end.text.splitlines()
    names = [line.partition(":")[0] for line in lines]
    assert names == (['"result"', '"graph"'] if content is CONTENTS[0] else [])
