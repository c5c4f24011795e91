"""Clients see no difference: the service answers the corpus as it did when it was recorded."""

import copy
import json
import re

import pytest

from tests.golden.service.__main__ import (
    FILE,
    REWRITE,
    changes,
    changes_since_recorded,
    recorded,
    text_of,
)
from tests.golden.service.answers import CALLS, answers
from tests.golden.service.calls import From, filled
from tests.golden.service.machine import reconciled
from tests.golden.service.masks import Masks, lasting_events, rounded
from tests.golden.service.summary import summary
from tests.service.api_routes import api_routes

MASKS = Masks({})


def test_the_service_answers_as_is_recorded():
    found = changes_since_recorded(dict(answers()))
    assert found == [], f"meant? `{REWRITE}` records the answers anew"


# No scene of the corpus has a mesh: `queries/test_geometry_routes.py` has.
_MESHES = "/v1/scenes/{scene}/geometry/{sha256}.glb"


def test_every_route_is_asked_and_answers_well():
    told = recorded()
    answered = {
        (call.method, call.path.partition("?")[0])
        for call in CALLS
        if told[call.name]["status"] < 300
    }
    for route in api_routes():
        if route.path == _MESHES:
            continue
        form = re.compile(re.sub(r"\{\w+\}", "[^/]+", route.path))
        (method,) = route.methods
        assert any(method == asked and form.fullmatch(path) for asked, path in answered), route.path


def test_every_kind_of_refusal_is_asked_for():
    told = list(recorded().values())
    statuses = {each["status"] for each in told}
    assert statuses >= {200, 201, 202, 204, 307, 400, 403, 404, 405, 409, 413, 415, 422, 429}
    refused = [each["body"] for each in told if each["status"] >= 400]
    assert len(refused) > 50
    assert len({problem["code"] for problem in refused}) >= 20
    failed = [each["body"]["failure"] for each in told if "failure" in (each["body"] or {})]
    assert len({failure["code"] for failure in failed if failure}) >= 9


def test_calls_have_names_of_their_own_and_the_file_has_their_order():
    names = [call.name for call in CALLS]
    assert len(set(names)) == len(names)
    assert list(recorded()) == names


def test_the_file_is_written_in_one_way_and_has_no_paths_of_a_machine():
    text = FILE.read_text(encoding="utf-8")
    assert text == text_of(json.loads(text))
    assert not re.search(r"/(tmp|root|home|work)/", text)


@pytest.mark.parametrize(
    ("part", "shown"),
    [
        ({"timings": {"load": 0.1}}, {"timings": {"load": "<seconds>"}}),
        ({"created_at": "2026-11-22T21:44:51.047032Z"}, {"created_at": "<instant>"}),
        ({"versions": {"drake": "1.58.0"}}, {"versions": {"drake": "<version>"}}),
        ({"state": "failed", "progress": 0.2}, {"state": "failed", "progress": "<measured>"}),
        ({"state": "succeeded", "progress": 1.0}, {"state": "succeeded", "progress": 1.0}),
        ({"positions": [0.1]}, {"positions": [0.1]}),
        ({"proven": True, "count": 3, "none": None}, {"proven": True, "count": 3, "none": None}),
    ],
)
def test_only_names_and_times_are_masked(part, shown):
    assert MASKS.document(part) == shown


def test_ids_are_numbered_so_that_answers_still_say_which_is_which():
    masks = Masks({"/some/folder": "<data>"})
    first, second = "pln_" + "a" * 20, "pln_" + "b" * 20
    shown = masks.document([f"/v1/plans/{first}", second, first, "/some/folder/x", "a" * 64])
    assert shown == ["/v1/plans/pln_1", "pln_2", "pln_1", "<data>/x", "sha256_1"]
    scene = {"revision": 1, "digest": "c" * 64, "created_at": ""}
    assert masks.document(scene)["digest"] == "c" * 64


def test_measured_positions_are_masked_and_planned_ones_are_not():
    status = {"state": "executing", "progress": 0.1, "time": 0.2, "positions": [1.0]}
    status |= {"tracking_error": 0.1, "contacts": []}
    shown = MASKS.document(status)
    assert {key for key, value in shown.items() if value == "<measured>"} == set(status) - {
        "state",
        "contacts",
    }
    ended = MASKS.document({**status, "state": "succeeded", "progress": 1.0})
    assert (ended["progress"], ended["time"]) == (1.0, 0.2)


def test_numbers_are_compared_to_six_digits():
    assert rounded(1.2345671) == rounded(1.23456709) == 1.23457
    assert rounded(1.23457) != rounded(1.23458)
    assert str(rounded(-1e-17)) == "0.0"


def test_one_number_of_many_changes_what_is_recorded():
    rows = [[0.1 * i, 0.2 * i] for i in range(500)]
    changed = copy.deepcopy(rows)
    changed[250][1] += 0.001
    one, other = ({"a": summary({"rows": each, "name": "x"})} for each in (rows, changed))
    assert len(text_of(one)) < 200
    (line,) = changes(one, other)
    assert line.startswith("a/rows/<digest> is ")
    assert changes(one, {}) == ["a: is gone"]


def test_events_that_come_by_the_clock_are_left_out():
    kinds = ["queued", "status", "progress", "status", "finished"]
    events = [{"event": kind, "id": i} for i, kind in enumerate(kinds)]
    assert [event["id"] for event in lasting_events(events)] == [0, 3, 4]


def test_bodies_say_what_earlier_answers_said():
    given = {"plan": {"id": "p", "path": [[1], [2]]}}
    body = {"plan": From("plan"), "last": [From("plan", "/path/1"), 3], "all": From("plan", "")}
    assert filled(body, given) == {"plan": "p", "last": [[2], 3], "all": given["plan"]}


@pytest.mark.parametrize(
    ("old", "new", "is_alike"),
    [
        (1.84504, 1.84505, True),
        (1.8, 1.9, False),
        (0.0, 0.01, False),
        (3, 4, False),
        (1, 1.0, False),
        (True, False, False),
        (None, 0.0, False),
        ("fails at 4.203 s", "fails at 4.204 s", True),
        ("fails at 4.203 s", "falls at 4.203 s", False),
        ([1.0], [1.0, 1.0], False),
        ({"<digest>": "a", "made_of": ["float"]}, {"<digest>": "b", "made_of": ["float"]}, True),
        ({"<digest>": "a", "made_of": ["float"]}, {"<digest>": "b", "made_of": ["int"]}, False),
        ({"points": [[0.0, 1.0]]}, {"points": [[0.5, 1.0]]}, True),
        ({"a": 1.0, "b": 2.0}, {"a": 1.0}, False),
        ({"a": 1.0}, {"a": 1.001, "b": 2.0}, False),
    ],
)
def test_on_another_machine_only_the_last_digits_may_differ(old, new, is_alike):
    assert (changes({"call": old}, {"call": reconciled(old, new)}) == []) == is_alike
