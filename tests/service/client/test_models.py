"""A newer server may tell more than this client knows."""

from wayproof_client import models


def test_a_newer_server_may_tell_more(solved):
    more = {**solved, "news": 1, "result": {**solved["result"], "news": {"deep": [2]}}}
    plan = models.Plan.model_validate(more)
    assert plan.result is not None
    told = plan.model_dump(mode="json")
    assert told["news"] == 1
    assert told["result"]["news"] == {"deep": [2]}
    assert told["result"]["trajectory"] == solved["result"]["trajectory"]
