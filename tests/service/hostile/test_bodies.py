"""Every hostile request of the table gets the answer that is right, and nothing of the server."""

import json
import math
import sys
from pathlib import Path

import pytest

from tests.service.hostile.bodies import CASES

ROOT = str(Path(__file__).parents[3])


def tells_of_the_server(text, *folders):
    """Whatever of the server's own insides a body shows."""
    inside = ["Traceback", 'File "', sys.prefix, ROOT, *map(str, folders)]
    return [part for part in inside if part in text]


def ask(client, scene, row):
    method_path, headers, body, *_ = row
    method, path = method_path.replace("{scene}", scene).split(" ")
    if body is not None and not isinstance(body, bytes):
        body = json.dumps(body).replace("{scene}", scene).encode()
    return client.request(method, path, headers=headers, content=body)


@pytest.mark.parametrize("name", CASES)
def test_the_answer_is_right(client, scene, settings, name):
    *_, status, code, word = CASES[name]
    answer = ask(client, scene, CASES[name])
    assert answer.headers["content-type"] == "application/problem+json", answer.text
    problem = answer.json()
    assert (answer.status_code, problem["status"], problem["code"]) == (status, status, code)
    assert word in problem["detail"]
    assert len(answer.content) < 20_000
    assert not tells_of_the_server(answer.text, settings.data_dir)


def test_pointers_point_at_the_fault(client, scene):
    """RFC 6901: following the pointer in what was sent leads to what is at fault."""
    for name in ("NaN in a goal", "NaN in one of several", "NaN in a pose"):
        row = CASES[f"request: {name}"]
        (fault,) = ask(client, scene, row).json()["evidence"]["faults"]
        part = row[2]
        for step in fault["pointer"].split("/")[1:]:
            part = part[int(step) if isinstance(part, list) else step]
        assert math.isnan(part)


def test_a_page_of_the_server_itself_may_ask(client, scene):
    headers = {"origin": "http://testserver"}
    body = {"group": "arm", "configurations": [[0.0] * 6]}
    assert client.post(f"/v1/scenes/{scene}/check", json=body, headers=headers).is_success
