"""WebhookStore: webhooks and what they are still to be told, in the database of the jobs.

Several servers may send for one webhook: a notice is claimed for a while before it is sent.
"""

import base64
import hashlib
import json
import secrets
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta

from sqlalchemy import Connection, Engine, delete, exists, func, insert, literal, select, update
from sqlalchemy.exc import IntegrityError

from service.errors import UnknownResource
from service.jobs.errors import IdempotencyConflict
from service.jobs.job import LoggedEvent
from service.jobs.store.sql.database import set_durability
from service.jobs.store.sql.tables import events
from service.jobs.store.sql.tables import jobs as jobs_table
from service.webhooks.event_types import type_of
from service.webhooks.message import Message
from service.webhooks.records import Notice, WebhookRecord, notices, webhook_of, webhooks

_SECRET_BYTES = 24
_IS_ENABLED = webhooks.c.disabled_at.is_(None)


class WebhookStore:
    """Reads and writes from any thread; each method is one transaction."""

    def __init__(self, engine: Engine) -> None:
        """Keep webhooks in a database that has their tables."""
        self._engine = engine
        # Of enabled webhooks, so that events which none wants cost nothing; None before a look.
        self._wanted: frozenset[str] | None = None

    def add(
        self, url: str, types: Sequence[str], key: str | None = None, *, client: str = ""
    ) -> WebhookRecord:
        """Return a new webhook with a new secret, or the one that was made by an idempotency key.

        Client and key give the id, which one webhook alone can have: the second request finds it.
        No client is told the secret of another one whose key it guesses.

        Args:
            url: Address that is told.
            types: Of the events that it is told of.
            key: The idempotency key, or None.
            client: Name of the API key that asks; empty where none is needed.

        Raises:
            IdempotencyConflict: The client used the key for another request.
        """
        identifier = f"whk_{secrets.token_hex(8) if key is None else _digest(client, key)}"
        try:
            return self._insert(identifier, url, types)
        except IntegrityError:
            if key is None:
                raise
        made = self.get(identifier)
        if (made.url, list(made.events)) != (url, list(types)):
            raise IdempotencyConflict.of(key, "webhook", identifier)
        return made

    def _insert(self, identifier: str, url: str, types: Sequence[str]) -> WebhookRecord:
        secret = base64.b64encode(secrets.token_bytes(_SECRET_BYTES)).decode()
        row = {
            "id": identifier,
            "url": url,
            "secret": f"whsec_{secret}",
            "events": json.dumps(list(types)),
            "created_at": _at(datetime.now(UTC)),
            "reason": "",
        }
        with self._engine.begin() as connection:
            set_durability(connection, is_durable=True)
            connection.execute(insert(webhooks).values(row))
        self.refresh()
        return self.get(identifier)

    def get(self, identifier: str) -> WebhookRecord:
        """Return a webhook.

        Raises:
            UnknownResource: There is none.
        """
        with self._engine.connect() as connection:
            found = connection.execute(select(webhooks).where(webhooks.c.id == identifier)).first()
        if found is None:
            raise UnknownResource.of("webhook", identifier)
        return webhook_of(found)

    def page(self, limit: int, before: int | None) -> list[WebhookRecord]:
        """Return webhooks older than one, newest first."""
        query = select(webhooks).order_by(webhooks.c.sequence.desc()).limit(limit)
        query = query if before is None else query.where(webhooks.c.sequence < before)
        with self._engine.connect() as connection:
            return [webhook_of(row) for row in connection.execute(query)]

    def delete(self, identifier: str) -> None:
        """Forget a webhook, and what it was to be told.

        Raises:
            UnknownResource: There is none.
        """
        with self._engine.begin() as connection:
            gone = connection.execute(delete(webhooks).where(webhooks.c.id == identifier))
            connection.execute(delete(notices).where(notices.c.webhook == identifier))
        self.refresh()
        if gone.rowcount == 0:
            raise UnknownResource.of("webhook", identifier)

    def enable(self, identifier: str) -> WebhookRecord:
        """Send to a webhook again, from now on.

        Raises:
            UnknownResource: There is none.
        """
        fresh = {"disabled_at": None, "failing_since": None, "reason": ""}
        with self._engine.begin() as connection:
            connection.execute(update(webhooks).where(webhooks.c.id == identifier).values(fresh))
        self.refresh()
        return self.get(identifier)

    def refresh(self) -> None:
        """Look which types of messages are wanted; another server may have added some."""
        with self._engine.connect() as connection:
            lists = connection.execute(select(webhooks.c.events).where(_IS_ENABLED)).scalars()
            self._wanted = frozenset(type_ for each in lists for type_ in json.loads(each))

    @property
    def is_needed(self) -> bool:
        """Whether there is a webhook that is told anything."""
        return bool(self._wanted)

    def note(self, connection: Connection, event: LoggedEvent) -> bool:
        """Have webhooks be told of an event, in the transaction that records it; whether any is."""
        type_ = type_of(event.job, event.type)
        if not type_ or (self._wanted is not None and type_ not in self._wanted):
            return False
        found = select(
            webhooks.c.id, literal(event.job), literal(event.number), literal(0), literal(event.at)
        ).where(_IS_ENABLED, webhooks.c.events.contains(f'"{type_}"'))
        names = ["webhook", "job", "number", "attempts", "due_at"]
        connection.execute(insert(notices).from_select(names, found))
        return True

    def waiting(self, now: datetime) -> list[WebhookRecord]:
        """Return the webhooks that something is to be sent to by now."""
        due = select(notices.c.webhook).where(notices.c.due_at <= _at(now))
        with self._engine.connect() as connection:
            rows = connection.execute(select(webhooks).where(_IS_ENABLED, webhooks.c.id.in_(due)))
            return [webhook_of(row) for row in rows]

    def claim(
        self, webhook: str, now: datetime, lease: timedelta, limit: int
    ) -> list[tuple[Notice, Message | None]]:
        """Return what is to be sent to a webhook, for no one else to send within a time.

        Of each job there is the oldest notice alone: what follows waits until that was taken. The
        message is None where the job is gone.
        """
        older = notices.alias()
        is_behind = exists().where(
            older.c.webhook == webhook,
            older.c.job == notices.c.job,
            older.c.sequence < notices.c.sequence,
        )
        columns = [notices.c[name] for name in ("sequence", "job", "number", "attempts")]
        query = select(*columns, notices.c.due_at).where(
            notices.c.webhook == webhook, notices.c.due_at <= _at(now), ~is_behind
        )
        with self._engine.begin() as connection:
            rows = connection.execute(query.order_by(notices.c.sequence).limit(limit)).all()
            claimed: list[tuple[Notice, Message | None]] = []
            for *fields, due_at in rows:
                notice = Notice(*fields)
                mine = (notices.c.sequence == notice.sequence) & (notices.c.due_at == due_at)
                lent = update(notices).where(mine).values(due_at=_at(now + lease))
                if connection.execute(lent).rowcount:
                    claimed.append((notice, _message(connection, notice)))
            return claimed

    def settle(self, notice: Notice) -> None:
        """Forget a notice: it was taken, or is given up."""
        with self._engine.begin() as connection:
            connection.execute(delete(notices).where(notices.c.sequence == notice.sequence))

    def note_success(self, webhook: WebhookRecord) -> None:
        """Note that a webhook has taken something, if it had failed before."""
        fresh = {"failing_since": None, "reason": ""}
        with self._engine.begin() as connection:
            query = update(webhooks).where(webhooks.c.id == webhook.id)
            connection.execute(query.where(webhooks.c.reason != "").values(fresh))

    def postpone(self, notice: Notice, until: datetime) -> None:
        """Have a notice be sent again at an instant."""
        changes = {"attempts": notices.c.attempts + 1, "due_at": _at(until)}
        with self._engine.begin() as connection:
            row = update(notices).where(notices.c.sequence == notice.sequence)
            connection.execute(row.values(changes))

    def note_failure(self, webhook: str, reason: str, now: datetime) -> datetime:
        """Note that a webhook failed, and return since when it has."""
        since = func.coalesce(webhooks.c.failing_since, _at(now))
        query = update(webhooks).where(webhooks.c.id == webhook)
        query = query.values(failing_since=since, reason=reason[:200])
        with self._engine.begin() as connection:
            found = connection.execute(query.returning(webhooks.c.failing_since)).scalar()
        return now if found is None else datetime.fromisoformat(found)

    def disable(self, webhook: str, now: datetime) -> None:
        """Send nothing to a webhook any more, nor what it was to be told."""
        with self._engine.begin() as connection:
            row = update(webhooks).where(webhooks.c.id == webhook)
            connection.execute(row.values(disabled_at=_at(now)))
            connection.execute(delete(notices).where(notices.c.webhook == webhook))
        self.refresh()


def _message(connection: Connection, notice: Notice) -> Message | None:
    """Return what a notice tells, None if its job is gone."""
    of_job = (events.c.job == notice.job) & (events.c.number == notice.number)
    columns = (jobs_table.c.scene, jobs_table.c.batch)
    query = select(events.c.type, events.c.data, events.c.at, *columns).where(of_job)
    query = query.join(jobs_table, jobs_table.c.id == events.c.job)
    row = connection.execute(query).first()
    if row is None:
        return None
    return Message(
        job=notice.job,
        number=notice.number,
        event=row.type,
        at=row.at,
        data=row.data,
        scene=row.scene,
        batch=row.batch,
    )


def _digest(client: str, key: str) -> str:
    # No name of a key and no header has a line break, so no two pairs read the same.
    return hashlib.sha256(f"{client}\n{key}".encode()).hexdigest()[:16]


def _at(instant: datetime) -> str:
    return instant.isoformat()
