"""Every refusal has a code of its own and a status that is declared."""

import pytest

from planning import errors as planning_errors
from planning.errors import AssetNotFound, SceneInvalid, UnknownName, WayproofError
from service.api.responses import problems
from service.errors import Refusal, UnknownResource, problem_of, status_of


def classes_below(base):
    return {base} | {leaf for child in base.__subclasses__() for leaf in classes_below(child)}


def refusals():
    return sorted(classes_below(Refusal) - {Refusal}, key=lambda kind: kind.__name__)


def test_codes_are_distinct():
    own = {k for k in classes_below(WayproofError) if k.__module__.split(".")[0] == "planning"}
    codes = [kind.code for kind in own if "code" in vars(kind)]
    codes += [kind.code for kind in refusals()]
    assert len(codes) == len(set(codes))


@pytest.mark.parametrize("kind", refusals(), ids=lambda kind: kind.__name__)
def test_every_refusal_can_be_declared(kind):
    assert status_of(kind("x")) == kind.status
    assert kind.status in problems(kind.status)


def test_one_and_several_are_told_apart():
    assert "; bodies: ['y']" in UnknownName.among("body", "x", ["y"]).detail
    assert "; keys: ['y']" in UnknownName.among("key", "x", ["y"]).detail
    assert "; frames: ['y']" in UnknownName.among("frame", "x", ["y"]).detail
    assert UnknownResource.of("regions", "x").detail == "there are no regions 'x'"
    assert UnknownResource.of("plan", "x").detail == "there is no plan 'x'"


@pytest.mark.parametrize("kind", ["frame", "group", "joint", "robot", "planner", "parameter"])
def test_a_name_that_does_not_exist_is_a_fault_of_the_payload(kind):
    assert status_of(UnknownName.among(kind, "x", ["y"])) == 422


def test_every_planning_error_has_a_status_below_500():
    for kind in classes_below(planning_errors.InputError) | {SceneInvalid, AssetNotFound}:
        assert status_of(kind("x")) in {409, 422}


def test_problem_has_all_fields():
    problem = problem_of("queue_full", 429, "later", {"bound": 3})
    assert problem == {
        "type": "urn:wayproof:problem:queue_full",
        "title": "Queue full",
        "status": 429,
        "code": "queue_full",
        "detail": "later",
        "evidence": {"bound": 3},
    }
