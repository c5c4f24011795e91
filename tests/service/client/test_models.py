"""What the client knows of answers is what the server says of them, and no more is needed."""

import pytest

from service.client import models

# By the names of their schemas.
KNOWN = {
    name: getattr(models, name)
    for name in (
        "Certificate", "Check", "Execution", "ExecutionStatus", "GoalsReport", "Group", "Joint",
        "Model", "Plan", "PlanResult", "RefineReport", "RetimeReport", "Scene", "SearchReport",
        "Stages", "Trajectory",
    )
}  # fmt: skip


# What `?include=` leaves out, for which the client never asks.
ALWAYS_THERE = {"PlanResult": {"trajectory", "certificate", "stages"}}


@pytest.mark.parametrize("name", KNOWN)
def test_the_document_has_every_member_and_requires_what_the_client_does(document, name):
    schemas = document["components"]["schemas"]
    # One that is posted as well has a schema for what is answered.
    schema = schemas.get(f"{name}-Output", schemas.get(name))
    fields = KNOWN[name].model_fields
    assert set(fields) <= set(schema["properties"])
    needed = {field for field, said in fields.items() if said.is_required()}
    assert needed <= {*schema["required"], *ALWAYS_THERE.get(name, ())}


def test_a_newer_server_may_tell_more(solved):
    more = {**solved, "news": 1, "result": {**solved["result"], "news": {"deep": [2]}}}
    plan = models.Plan.model_validate(more)
    assert plan.result is not None
    told = plan.model_dump(mode="json")
    assert told["news"] == 1
    assert told["result"]["news"] == {"deep": [2]}
    assert told["result"]["trajectory"] == solved["result"]["trajectory"]
