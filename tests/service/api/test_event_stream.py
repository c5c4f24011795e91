"""Events of jobs are what the OpenAPI document says, and say when they happened."""

import json
from datetime import UTC, datetime

import pytest
from jsonschema import Draft202012Validator

from service.client.events import decode_events


@pytest.fixture(scope="module")
def jobs(client, few_regions):
    """The ids of a plan, of regions and of an execution that was paused on its way."""
    robots = [{"name": "arm", "model": "ur5e", "positions": "home"}]
    scene = client.post("/v1/scenes", json={"name": "events", "robots": robots}).json()["id"]
    request = {"scene": scene, "group": "arm", "goal": {"type": "configuration", "name": "ready"}}
    request["search"] = {"allowed_planning_time": 60.0}
    plan = client.post("/v1/plans?wait=60", json=request).json()
    body = {"plan": plan["id"], "driver": "simulated", "speed": 1.0}
    name = client.post("/v1/executions", json=body).json()["id"]
    for verb in ("pause", "resume"):
        assert client.post(f"/v1/executions/{name}/{verb}").status_code == 200
    client.post(f"/v1/executions/{name}/speed", json={"speed": 100.0})
    return {"plan": plan["id"], "regions": few_regions["id"], "execution": name}


def schema_of(document, path):
    """The schema of the events that a path streams, closed: it says all that is in them."""
    answer = document["paths"][path]["get"]["responses"]["200"]["content"]["text/event-stream"]
    assert set(answer) == {"schema"}
    name = answer["schema"]["$ref"].split("/")[-1]
    schemas = {
        name: {**schema, "additionalProperties": False} if "properties" in schema else schema
        for name, schema in document["components"]["schemas"].items()
    }
    schemas["Failure"] = {**schemas["Failure"], "additionalProperties": True}
    return {"$ref": f"#/components/schemas/{name}", "components": {"schemas": schemas}}


def data_schema(schema, kind):
    """The schema of the data of events of a kind, which are JSON in a string."""
    schemas = schema["components"]["schemas"]
    kinds = schemas[schema["$ref"].split("/")[-1]]["discriminator"]["mapping"]
    data = schemas[kinds[kind].split("/")[-1]]["properties"]["data"]
    assert data["contentMediaType"] == "application/json"
    return Draft202012Validator({**data["contentSchema"], "components": schema["components"]})


@pytest.mark.parametrize(
    ("path", "types"),
    [
        ("/v1/plans/{plan}/events", {"queued", "started", "stage", "finished"}),
        ("/v1/regions/{regions}/events", {"queued", "started", "stage", "finished"}),
        (
            "/v1/executions/{execution}/events",
            {"queued", "started", "controls", "status", "finished"},
        ),
    ],
)
def test_events_are_what_is_declared(client, document, jobs, path, types):
    begun = datetime.now(UTC)
    with client.stream("GET", path.format(**jobs)) as answer:
        events = list(decode_events(answer))
    assert {event.type for event in events} >= types
    check = Draft202012Validator(schema_of(document, path))
    for event in events:
        shown = {"id": event.id, "event": event.type, "data": json.dumps(event.data)}
        assert [fault.message for fault in check.iter_errors(shown)] == [], shown
        of_data = data_schema(check.schema, event.type)
        assert [fault.message for fault in of_data.iter_errors(event.data)] == [], shown
    times = [datetime.fromisoformat(event.data["at"]) for event in events]
    assert times == sorted(times)
    assert times[0] < begun


def test_the_schema_refuses_what_is_no_event(document):
    check = Draft202012Validator(schema_of(document, "/v1/plans/{plan}/events"))
    at = "2026-01-01T00:00:00Z"
    good = {"id": "1", "event": "started", "data": json.dumps({"at": at})}
    assert check.is_valid(good)
    assert not check.is_valid({**good, "event": "nothing"})
    assert not check.is_valid({**good, "data": {"at": at}})
    of_data = data_schema(check.schema, "started")
    assert of_data.is_valid({"at": at})
    assert not of_data.is_valid({})
    assert not of_data.is_valid({"at": at, "more": 1})
