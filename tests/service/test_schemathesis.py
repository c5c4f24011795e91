"""Schemathesis: whatever is sent, the answers are as declared and never a 5xx."""

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tests.profiles import PROFILE, num_cases
from tests.service.api_routes import api_routes, takes_data
from tests.service.conftest import BLOCK_SCENE
from tests.service.declared import ask, checks, library

# Replays are megabytes, and the stream of a live state has no end.
NOT_CALLED = {"getReplay", "streamSceneState"}
# Bad data is one of many ways to be bad; of good data both known and unknown names are tried.
EXAMPLES = {"positive": num_cases(2, 60), "negative": num_cases(1, 60)}
RULES = settings(
    deadline=None,
    derandomize=not PROFILE.is_campaign,
    database=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)


def cases():
    """Every operation with good data, and with bad data if it takes any."""
    for route in api_routes():
        if route.operation_id not in NOT_CALLED:
            yield route.operation_id, "positive"
            if takes_data(route):
                yield route.operation_id, "negative"


@pytest.fixture(scope="module")
def operations(document):
    schema = library().openapi.from_dict(document)
    found = [result.ok() for result in schema.get_all_operations()]
    return {operation.definition.raw["operationId"]: operation for operation in found}


@pytest.fixture(scope="module")
def own_scene(client):
    """A scene that no other test needs: what is called here edits it."""
    return client.post("/v1/scenes", json=BLOCK_SCENE).json()["id"]


def to_delete(client, name):
    """What an operation may delete: others need what is there already."""
    if name not in {"deleteScene", "deletePlan", "deleteRegions"}:
        return {}
    scene = client.post("/v1/scenes", json=BLOCK_SCENE).json()["id"]
    goal = {"type": "configuration", "name": "ready"}
    plan = {"scene": scene, "group": "arm", "goal": goal}
    grow = {"group": "arm", "num_regions": 1, "num_free": 100, "iterations": 1, "along": "nothing"}
    made = {
        "deletePlan": lambda: client.post("/v1/plans?wait=60", json=plan).json(),
        "deleteRegions": lambda: client.post(
            f"/v1/scenes/{scene}/regions?wait=60", json=grow
        ).json(),
    }
    if name == "deleteScene":
        return {"scene": scene}
    return {name.removeprefix("delete").lower(): made[name]()["id"]}


def test_every_operation_of_the_document_is_called(operations):
    assert {name for name, _ in cases()} | NOT_CALLED == set(operations)
    with_data = {
        name
        for name, operation in operations.items()
        if {"parameters", "requestBody"} & set(operation.definition.raw)
    }
    assert {name for name, mode in cases() if mode == "negative"} == with_data - NOT_CALLED


# Schemathesis draws from `random` in its strategies; Hypothesis seeds it, but complains.
@pytest.mark.filterwarnings("ignore:Do not use the `random` module inside strategies")
@pytest.mark.campaign
@pytest.mark.parametrize(("name", "mode"), list(cases()))
def test_answers_are_as_declared(  # noqa: PLR0913, PLR0917  (what it knows of are fixtures)
    client, own_scene, solved, few_regions, operations, name, mode
):
    known = {"scene": own_scene, "plan": solved["id"], "name": "ur5e", "regions": few_regions["id"]}
    known |= to_delete(client, name)
    asked = operations[name].as_strategy(generation_mode=library().GenerationMode(mode))

    @settings(RULES, max_examples=EXAMPLES[mode])
    @given(case=asked, is_known=st.booleans())
    def check(case, is_known):
        if is_known:
            for parameter in set(case.path_parameters) & set(known):
                case.path_parameters[parameter] = known[parameter]
        case.validate_response(ask(client, case), checks=checks())

    check()
