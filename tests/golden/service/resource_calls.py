"""Calls about resources as such: batches, keys of scenes, parts of results, webhooks, deletion."""

from tests.golden.service.calls import Call, get, post
from tests.golden.service.plan_calls import plan
from tests.golden.service.scene_calls import SQUARE

_KEY = {"idempotency-key": "scene"}
_ENDED = plan("", {"type": "configuration", "name": "beyond"}).body
_ENDLESS = {"planner": "RRTConnect", "allowed_planning_time": 600.0}
_OUT = {"type": "joint", "positions": [-0.3, 0.3, 0.0]}
_BLOCKED = plan("", _OUT, "cell", search=_ENDLESS).body
_AMISS = {**_ENDED, "group": "bodi"}
_HOOK = {"url": "https://93.184.216.34/told", "events": ["plan.finished"]}


def _delete(name: str, path: str) -> Call:
    return Call(name, "DELETE", path)


RESOURCE_CALLS = (
    post("keyed_scene", "/v1/scenes", SQUARE, headers=_KEY),
    post("keyed_scene_again", "/v1/scenes", SQUARE, headers=_KEY),
    post("keyed_scene_of_another_body", "/v1/scenes", {**SQUARE, "name": "x"}, headers=_KEY),
    post("batch", "/v1/plans/batch?wait=60", {"problems": [_ENDED]}),
    get("batch_again", "/v1/batches/{batch}"),
    get("batches", "/v1/batches?limit=1"),
    get("batch_events", "/v1/batches/{batch}/events"),
    post("batch_that_ended", "/v1/batches/{batch}/cancel"),
    get("plans_of_a_batch", "/v1/plans?batch={batch}"),
    post("batch_without_room", "/v1/plans/batch", {"problems": [_ENDED] * 2}),
    post("batch_amiss", "/v1/plans/batch", {"problems": [_ENDED, _AMISS]}),
    post("empty_batch", "/v1/plans/batch", {"problems": []}),
    _delete("delete_batch", "/v1/batches/{batch}"),
    get("deleted_batch", "/v1/batches/{batch}"),
    get("parts", "/v1/plans/{configuration}?include=certificate"),
    get("no_parts", "/v1/plans/{configuration}?include="),
    get("unknown_part", "/v1/plans/{configuration}?include=samples"),
    post("blocked", "/v1/plans", _BLOCKED),
    get("running_blocked", "/v1/plans/{blocked}", until=("stage", "search"), is_moving=True),
    _delete("delete_open_plan", "/v1/plans/{blocked}"),
    post("end_of_blocked", "/v1/plans/{blocked}/cancel", is_moving=True),
    get("ended_blocked", "/v1/plans/{blocked}", until=("state", "canceled")),
    _delete("delete_plan", "/v1/plans/{blocked}"),
    _delete("delete_plan_again", "/v1/plans/{blocked}"),
    _delete("delete_execution", "/v1/executions/{execution}"),
    _delete("delete_regions", "/v1/regions/{regions}"),
    post("webhook", "/v1/webhooks", _HOOK),
    post("webhook_of_this_machine", "/v1/webhooks", {**_HOOK, "url": "http://127.0.0.1/"}),
    post("webhook_of_no_address", "/v1/webhooks", {**_HOOK, "url": "file:///x"}),
    get("webhook_again", "/v1/webhooks/{webhook}"),
    get("webhooks", "/v1/webhooks"),
    post("enable_webhook", "/v1/webhooks/{webhook}/enable"),
    _delete("delete_webhook", "/v1/webhooks/{webhook}"),
    _delete("delete_webhook_again", "/v1/webhooks/{webhook}"),
)
