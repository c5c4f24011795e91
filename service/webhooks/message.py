"""Message: what a webhook is told of an event, and how it is signed (Standard Webhooks 1.0)."""

import json
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from service.webhooks.event_types import KINDS, type_of

# Of a failure; evidence may be megabytes, and is at the job's own address.
_TOLD = ("code", "stage", "detail")


@dataclass(frozen=True)
class Message:
    """An event of a job, for those outside.

    Attributes:
        job: Its id.
        number: Of the event in the job's stream.
        event: Its type there.
        at: When it happened (ISO 8601, UTC).
        data: Of the event.
        scene: Id of the job's scene, if it has one.
        batch: Id of the batch that it is of, or None.
    """

    job: str
    number: int
    event: str
    at: str
    data: dict[str, Any]
    scene: str | None
    batch: str | None

    @property
    def id(self) -> str:
        """The same each time it is sent: who gets it twice can tell."""
        return f"msg_{self.job}_{self.number}"

    @property
    def body(self) -> str:
        """What is sent, as JSON."""
        failure = self.data.get("failure")
        told: dict[str, Any] = {
            "kind": KINDS[self.job.partition("_")[0]],
            "id": self.job,
            "event": self.number,
            "scene": self.scene,
            "batch": self.batch,
        }
        if "state" in self.data:
            told["state"] = self.data["state"]
            told["failure"] = failure and {name: failure.get(name) for name in _TOLD}
        if "reason" in self.data:
            told["reason"] = self.data["reason"]
        at = self.at.replace("+00:00", "Z")
        return json.dumps({"type": type_of(self.job, self.event), "timestamp": at, "data": told})


def signed_headers(message: Message, body: str, secret: str, now: datetime) -> dict[str, str]:
    """Return the headers of a message that is sent at an instant.

    Args:
        message: That is sent.
        body: Of it.
        secret: Of the webhook.
        now: When (UTC).
    """
    from standardwebhooks import Webhook  # noqa: PLC0415  (only a server with webhooks needs it)

    return {
        "content-type": "application/json",
        "webhook-id": message.id,
        "webhook-timestamp": str(int(now.timestamp())),
        "webhook-signature": Webhook(secret).sign(message.id, now, body),
    }
