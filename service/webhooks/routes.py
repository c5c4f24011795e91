"""/v1/webhooks: register addresses that are told what happens to jobs."""

from contextlib import suppress
from functools import partial
from typing import Annotated

from anyio import to_thread
from fastapi import APIRouter, Depends, Path, Request, Response

from service.api.dependencies import CALLER, SettingsDep
from service.api.paging import Cursor, Limit, before, cursor_of
from service.api.responses import problems
from service.api.routing.strict_route import StrictRoute
from service.api.submission import KeyHeader
from service.webhooks.addresses import resolve
from service.webhooks.models import NewWebhook, Webhook, WebhookPage, WebhookRequest
from service.webhooks.store import WebhookStore

router = APIRouter(route_class=StrictRoute, prefix="/v1/webhooks", tags=["webhooks"])

type WebhookId = Annotated[str, Path(max_length=128, description="Id of a webhook")]


async def _webhooks(request: Request) -> WebhookStore:
    webhooks: WebhookStore = request.app.state.webhooks
    return webhooks


type WebhooksDep = Annotated[WebhookStore, Depends(_webhooks)]


@router.post(
    "",
    operation_id="createWebhook",
    status_code=201,
    responses=problems(400, 409, 413, 422, 503),
)
async def create_webhook(
    request: WebhookRequest,
    http: Request,
    webhooks: WebhooksDep,
    settings: SettingsDep,
    response: Response,
    idempotency_key: KeyHeader = None,
) -> NewWebhook:
    """Register an address; it is told what happens from now on, signed with the `secret`.

    Messages are as Standard Webhooks has them, sent again until they are taken. The same key and
    request of the same client give the same webhook and secret: an answer that was lost is asked
    for again.
    """
    with suppress(OSError):  # a name may get its address later; each time it is looked at anew
        await resolve(request.url, may_be_private=settings.webhook_private_addresses)
    add = partial(webhooks.add, client=http.scope.get(CALLER, ""))
    record = await to_thread.run_sync(add, request.url, request.events, idempotency_key)
    response.headers["Location"] = f"/v1/webhooks/{record.id}"
    return NewWebhook.model_validate(record)


@router.get("", operation_id="listWebhooks", responses=problems(422))
async def list_webhooks(
    webhooks: WebhooksDep, limit: Limit = 50, cursor: Cursor = None
) -> WebhookPage:
    """List webhooks, newest first, without their secrets."""
    found = await to_thread.run_sync(webhooks.page, limit + 1, before(cursor))
    following = found[limit - 1].sequence if len(found) > limit else None
    items = [Webhook.from_record(record) for record in found[:limit]]
    return WebhookPage(items=items, next=cursor_of(following))


@router.get("/{webhook}", operation_id="getWebhook", responses=problems(404, 422))
async def get_webhook(webhook: WebhookId, webhooks: WebhooksDep) -> Webhook:
    """Show a webhook: whether it takes what it is told."""
    return Webhook.from_record(await to_thread.run_sync(webhooks.get, webhook))


@router.post("/{webhook}/enable", operation_id="enableWebhook", responses=problems(404, 422))
async def enable_webhook(webhook: WebhookId, webhooks: WebhooksDep) -> Webhook:
    """Send to a webhook again that was disabled; what happened meanwhile it is not told."""
    return Webhook.from_record(await to_thread.run_sync(webhooks.enable, webhook))


@router.delete(
    "/{webhook}",
    operation_id="deleteWebhook",
    status_code=204,
    response_class=Response,  # which has no content type
    responses=problems(404, 422),
)
async def delete_webhook(webhook: WebhookId, webhooks: WebhooksDep) -> None:
    """Forget a webhook: it is told nothing more."""
    await to_thread.run_sync(webhooks.delete, webhook)
