"""The HTTP examples of the guide are what the service takes; nothing is planned here."""

import json
from typing import Any

import pytest
from pydantic import TypeAdapter

from service.plans.models.goals import Goal
from service.plans.models.request import PlanRequest
from service.plans.models.search import Search
from service.queries.models.kinematics import IkRequest
from tests.conventions.guide import PAGES, ROOT, Call, calls, members, values
from tests.service.api_routes import api_routes

LEAST = {"scene": "scn_0", "group": "arm", "goal": {"type": "configuration", "name": "ready"}}


def shown(what: Any) -> list[Any]:
    return [
        pytest.param(entry, id=f"{page.stem}-{number}")
        for page in PAGES
        for number, entry in enumerate(what(page))
    ]


def type_of(value: dict[str, Any]) -> Any:
    if "type" in value:
        return Goal
    return PlanRequest if "scene" in value else IkRequest


def test_there_are_examples_of_every_kind() -> None:
    """Otherwise the tests below might pass because they find nothing."""
    assert min(len(shown(calls)), len(shown(values)), len(shown(members))) > 5


@pytest.mark.parametrize("call", shown(calls))
def test_calls_are_routed_and_their_bodies_accepted(call: Call) -> None:
    found = [
        route
        for route in api_routes()
        if route.path_regex.match(call.path) and call.method in route.methods
    ]
    assert found, call
    needed = [found[0].dependant, *found[0].dependant.dependencies]
    assert set(call.query) <= {query.alias for each in needed for query in each.query_params}
    if call.body is not None:
        model = found[0].body_field.field_info.annotation
        TypeAdapter(model).validate_json(json.dumps(call.body))


@pytest.mark.parametrize("value", shown(values))
def test_bodies_and_goals_are_accepted(value: dict[str, Any]) -> None:
    TypeAdapter(type_of(value)).validate_json(json.dumps(value))


@pytest.mark.parametrize("member", shown(members))
def test_members_are_accepted(member: dict[str, Any]) -> None:
    PlanRequest.model_validate_json(json.dumps({**LEAST, **member}))


def test_the_table_of_the_search_names_every_field() -> None:
    page = (ROOT / "docs" / "how-to" / "plan" / "search.md").read_text()
    named = {line.split("`")[1] for line in page.splitlines() if line.startswith("| `")}
    assert set(Search.model_fields) <= named
