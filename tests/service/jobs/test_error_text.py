"""Errors cross to the server and are what they were."""

import math

import pytest

from planning import errors as planning_errors
from planning.errors import UnknownName, WayproofError
from service.jobs.error_text import RemoteFailure, dump_error, load_error


def classes_below(base):
    return {base} | {leaf for child in base.__subclasses__() for leaf in classes_below(child)}


OURS = sorted(
    (k for k in classes_below(WayproofError) if k.__module__ == planning_errors.__name__),
    key=lambda kind: kind.__name__,
)


STAGED = [planning_errors.DeadlineExceeded, planning_errors.NoPathFound, planning_errors.Contact]


@pytest.mark.parametrize("kind", OURS, ids=lambda kind: kind.__name__)
def test_an_error_keeps_its_class_detail_and_evidence(kind):
    told = load_error(
        dump_error(kind("why \u2028 \0", {"depth": 0.1 + 0.2, "pairs": [["a", "b"]]}))
    )
    assert type(told) is kind
    assert told.detail == "why \u2028 \0"
    assert told.evidence == {"depth": 0.1 + 0.2, "pairs": [["a", "b"]]}


@pytest.mark.parametrize("kind", STAGED)
def test_a_failure_keeps_the_stage_it_was_in_and_its_timings(kind):
    failure = kind("late").in_stage("retime")
    failure.timings = {"goals": 0.25, "retime": 1.5, "total": 2.0}
    told = load_error(dump_error(failure))
    assert (type(told), told.stage, told.timings) == (kind, "retime", failure.timings)


def test_classes_with_builders_cross_too():
    told = load_error(dump_error(UnknownName.among("frame", "x", ["y", "z"])))
    assert isinstance(told, UnknownName)
    assert told.evidence["known"] == ["y", "z"]


def test_a_class_that_only_the_worker_knows_keeps_its_code_and_stage():
    class Strange(WayproofError):
        code = "strange"
        stage = "nowhere"

    told = load_error(dump_error(Strange("odd", {"n": math.inf, "set": 1})))
    assert isinstance(told, RemoteFailure)
    assert (told.code, told.stage, told.detail) == ("strange", "nowhere", "odd")
    assert told.evidence == {"n": None, "set": 1}


def test_evidence_that_is_no_json_does_not_hide_the_error():
    told = load_error(dump_error(UnknownName("odd", {"what": {1}})))
    assert isinstance(told, UnknownName)
    assert "{1}" in told.evidence["shown"]
