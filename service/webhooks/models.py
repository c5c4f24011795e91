"""Webhooks as JSON."""

from datetime import datetime
from typing import Annotated, Self
from urllib.parse import urlsplit

from pydantic import AfterValidator, ConfigDict, Field, StringConstraints

from service.api.models import RequestModel, ResponseModel
from service.webhooks.event_types import WebhookEvent
from service.webhooks.records import WebhookRecord

_ENDS = [WebhookEvent.PLAN_FINISHED, WebhookEvent.REGIONS_FINISHED, WebhookEvent.EXECUTION_FINISHED]


def _checked(url: str) -> str:
    parts = urlsplit(url)
    if parts.scheme not in {"http", "https"} or not parts.hostname:
        message = "it is no http:// or https:// URL with a host"
        raise ValueError(message)
    if parts.username is not None or parts.password is not None:
        message = "a URL with a user or a password is not taken: messages are signed instead"
        raise ValueError(message)
    _ = parts.port  # a ValueError if it is none
    return url


type _Url = Annotated[
    str,
    StringConstraints(pattern=r"^https?://[\x21-\x7e]+$", max_length=2000),
    AfterValidator(_checked),
]


class WebhookRequest(RequestModel):
    """Register an address that is told what happens to jobs."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"url": "https://example.org/wayproof", "events": ["plan.finished"]}]
        }
    )

    url: _Url = Field(
        description="Address to which messages are posted; answer them with a status of 2xx"
    )
    events: Annotated[list[WebhookEvent], Field(min_length=1, max_length=len(WebhookEvent))] = (
        Field(default=_ENDS, description="Events that are told; by default the ends of all jobs")
    )


class Webhook(ResponseModel):
    """An address that is told what happens to jobs."""

    id: str = Field(description="Id of the webhook")
    url: str = Field(description="Address to which messages are posted")
    events: list[WebhookEvent] = Field(description="Events that are told")
    created_at: datetime = Field(description="Time of the registration (UTC)")
    failing_since: datetime | None = Field(
        description="Time since which it has taken nothing that was sent (UTC); null if "
        "it takes them"
    )
    disabled_at: datetime | None = Field(
        description="Time since which nothing is sent, because it failed for days or said "
        "410 (UTC); null if it is enabled"
    )
    reason: str = Field(description="Reason of the last failure since a success, or empty")

    @classmethod
    def from_record(cls, record: WebhookRecord) -> Self:
        """Return a webhook as it is shown: without its secret."""
        return cls.model_validate(record)


class NewWebhook(Webhook):
    """A webhook that was just registered."""

    secret: str = Field(
        description="Secret that signs messages, `whsec_` and base64: it is shown once"
    )


class WebhookPage(ResponseModel):
    """Webhooks, newest first."""

    items: list[Webhook] = Field(description="Webhooks on this page")
    next: str | None = Field(description="Cursor of the next page; null on the last one")
