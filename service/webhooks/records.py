"""The tables of webhooks: where they lead, and what they are still to be told."""

import json
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import BigInteger, Column, Index, Integer, MetaData, Row, String, Table, Text

metadata = MetaData()

webhooks = Table(
    "webhooks",
    metadata,
    Column("sequence", BigInteger().with_variant(Integer, "sqlite"), primary_key=True),
    Column("id", String(64), nullable=False, unique=True),
    Column("url", Text, nullable=False),
    Column("secret", String(100), nullable=False),
    # A JSON list of types.
    Column("events", Text, nullable=False),
    Column("created_at", String(40), nullable=False),
    Column("failing_since", String(40), nullable=True),
    Column("disabled_at", String(40), nullable=True),
    Column("reason", String(200), nullable=False),
)

# What is still to be told: a row for each message that a webhook has not taken yet. It is written
# with the event itself, and so is neither lost nor told of what was never recorded.
notices = Table(
    "webhook_notices",
    metadata,
    Column("sequence", BigInteger().with_variant(Integer, "sqlite"), primary_key=True),
    Column("webhook", String(64), nullable=False),
    Column("job", String(64), nullable=False),
    Column("number", Integer, nullable=False),
    Column("attempts", Integer, nullable=False),
    Column("due_at", String(40), nullable=False),
    Index("webhook_notices_of_job", "webhook", "job", "sequence"),
    Index("webhook_notices_by_time", "due_at"),
)


@dataclass(frozen=True)
class WebhookRecord:
    """A webhook.

    Attributes:
        sequence: Order of creation.
        id: Of it.
        url: Where messages are sent.
        secret: That they are signed with, as Standard Webhooks writes it.
        events: Types of messages.
        created_at: When (UTC).
        failing_since: When the first of the failures since the last success was, if it fails.
        disabled_at: Since when nothing is sent, if so.
        reason: Of the last failure, or empty.
    """

    sequence: int
    id: str
    url: str
    secret: str
    events: tuple[str, ...]
    created_at: datetime
    failing_since: datetime | None
    disabled_at: datetime | None
    reason: str


@dataclass(frozen=True)
class Notice:
    """An event that a webhook is still to be told.

    Attributes:
        sequence: Order in which they came up.
        job: Id.
        number: Of the event in the job's stream.
        attempts: How often it was sent in vain.
    """

    sequence: int
    job: str
    number: int
    attempts: int


def webhook_of(row: Row[Any]) -> WebhookRecord:
    """Return the webhook of a row."""
    return WebhookRecord(
        sequence=row.sequence,
        id=row.id,
        url=row.url,
        secret=row.secret,
        events=tuple(json.loads(row.events)),
        created_at=datetime.fromisoformat(row.created_at),
        failing_since=_instant(row.failing_since),
        disabled_at=_instant(row.disabled_at),
        reason=row.reason,
    )


def _instant(text: str | None) -> datetime | None:
    return None if text is None else datetime.fromisoformat(text)
