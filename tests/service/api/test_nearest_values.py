"""Misspelt values: the error says where it stands, and which of the known values was meant."""

import pytest

HOME = {"type": "configuration", "name": "home"}
PLAN = {"scene": "scn_0", "group": "arm", "goal": HOME}
CASES = {
    "literal": ("/v1/plans", {**PLAN, "retime": {"method": "topra"}}, "/retime/method", "toppra"),
    "tag": (
        "/v1/plans", {**PLAN, "goal": {"type": "configuraton", "name": "home"}}, "/goal/type",
        "configuration",
    ),
    "tag in a list": (
        "/v1/plans", {**PLAN, "path_constraints": [{"type": "orientatoin"}]},
        "/path_constraints/0/type", "orientation",
    ),
    "literal or object": (
        "/v1/executions", {"plan": "pln_0", "driver": "simulatd"}, "/driver", "simulated",
    ),
    "literal in a list": (
        "/v1/webhooks", {"url": "https://93.184.216.34/", "events": ["plan.finishd"]}, "/events/0",
        "plan.finished",
    ),
    "tag of an edit": (
        "/v1/scenes/scn_0", {"operations": [{"op": "ad"}]}, "/operations/0/op", "add",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_misspelt_value_is_told_the_right_one(client, name):
    path, body, pointer, right = CASES[name]
    answer = client.request("PATCH" if "scn_0" in path else "POST", path, json=body)
    problem = answer.json()
    assert (answer.status_code, problem["code"]) == (422, "request_invalid"), problem
    (error,) = problem["errors"]
    assert (error["pointer"], error["nearest"][0]) == (pointer, right)
    assert f"did you mean '{right}'?" in error["message"]
    assert "parameter" not in error


def test_a_value_that_resembles_none_has_no_candidates(client):
    problem = client.post("/v1/plans", json={**PLAN, "retime": {"method": "xyz"}}).json()
    assert problem["errors"][0]["nearest"] == []
    assert "did you mean" not in problem["detail"]


PARAMETERS = {
    "enum": ("/v1/plans?state=succeded", "state", ["succeeded"]),
    "literal": ("/v1/plans/{plan}/trajectory?format=jsn", "format", ["json"]),
    "number": ("/v1/plans?limit=many", "limit", []),
    "path": ("/v1/plans/{plan}/plots/velocty.svg", "name", ["velocity"]),
    "unknown name": ("/v1/plans?stat=queued", "stat", ["state"]),
    "unknown part": ("/v1/plans/{plan}?include=certificate,trajectry", "include", ["trajectory"]),
    "twice": ("/v1/plans?limit=1&limit=2", "limit", []),
}


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_fault_of_a_parameter_names_it(client, solved, name):
    path, parameter, nearest = PARAMETERS[name]
    answer = client.get(path.format(plan=solved["id"]))
    problem = answer.json()
    assert answer.status_code == 422, problem
    (error,) = problem["errors"]
    assert (error["pointer"], error["parameter"]) == ("", parameter)
    assert error["nearest"][: len(nearest)] == nearest
    assert error["message"].count(f".{parameter}: ") == 1


def test_a_header_is_named_as_it_is_sent(client, solved):
    headers = {"Last-Event-ID": "x" * 50}
    (error,) = client.get(f"/v1/plans/{solved['id']}/events", headers=headers).json()["errors"]
    assert error["parameter"] == "Last-Event-ID"
