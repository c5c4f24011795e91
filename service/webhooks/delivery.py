"""WebhookDelivery: sends what webhooks are to be told, again and again until they take it.

What is to be sent is in the database, so an end of the server loses nothing. Each message is sent
at least once, those of a job in their order. A webhook that fails does not hold up others.
"""

import asyncio
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import TYPE_CHECKING

from anyio import CapacityLimiter, to_thread
from sqlalchemy import Connection
from sqlalchemy.exc import SQLAlchemyError

from service.errors import AddressNotAllowed
from service.jobs.job import LoggedEvent
from service.webhooks.addresses import resolve
from service.webhooks.message import Message, signed_headers
from service.webhooks.records import Notice, WebhookRecord
from service.webhooks.store import WebhookStore

if TYPE_CHECKING:
    import httpx

# What Standard Webhooks recommends, nearly: 5 s to a day; three days in all [s].
RETRY_DELAYS = (5, 30, 120, 600, 1800, 7200, 18_000, 36_000, 50_400, 72_000, 86_400)
# That an address may take to answer [s].
_TIMEOUT = 15.0
# For which no other server sends what this one has begun to send.
_LEASE = timedelta(seconds=60)
# Messages of one webhook that are under way at once.
_AT_ONCE = 8
# Between two looks at the database, if nothing happens here [s].
_PERIOD = 2.0
# For what was noted to be committed [s].
_PAUSE = 0.02
_GONE = 410
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class DeliveryTerms:
    """On what terms messages are sent.

    Attributes:
        may_be_private: Whether to loopback and private addresses too.
        failure_days: After which a webhook that took nothing is disabled.
        delays: Before each further attempt [s]; after the last one a message is given up.
    """

    may_be_private: bool = False
    failure_days: float = 5.0
    delays: Sequence[float] = RETRY_DELAYS


def _utc_now() -> datetime:
    return datetime.now(UTC)


class WebhookDelivery:
    """Sends from one event loop, for as long as the server runs."""

    def __init__(
        self,
        store: WebhookStore,
        terms: DeliveryTerms,
        clock: Callable[[], datetime] = _utc_now,
    ) -> None:
        """Send what `store` has; `clock` tells the time (UTC)."""
        self._store = store
        self._terms = terms
        self._clock = clock
        self._asked = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        self._sending: dict[str, asyncio.Task[None]] = {}
        self._turn = CapacityLimiter(1)

    def note(self, connection: Connection, event: LoggedEvent) -> None:
        """Have webhooks be told of an event, in the transaction of its record; from any thread."""
        if self._store.note(connection, event) and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._asked.set)

    async def run(self) -> None:
        """Send until canceled; what is under way then is sent again by the next server."""
        try:
            while True:
                try:
                    await self._send_due()
                except SQLAlchemyError:
                    _log.exception("webhooks could not be read")
                await self._next()
        finally:
            for task in self._sending.values():
                task.cancel()

    async def _next(self) -> None:
        try:
            async with asyncio.timeout(_PERIOD):
                await self._asked.wait()
        except TimeoutError:
            return
        self._asked.clear()
        await asyncio.sleep(_PAUSE)

    async def _ask[*Ts, T](self, question: Callable[[*Ts], T], *given: *Ts) -> T:
        """Ask the database, one question after another, however many webhooks there are.

        Where one writes at a time, many that wait for their turn keep jobs waiting as well.
        """
        return await to_thread.run_sync(question, *given, limiter=self._turn)

    async def _send_due(self) -> None:
        await self._ask(self._store.refresh)
        if not self._store.is_needed:
            return
        for webhook in await self._ask(self._store.waiting, self._clock()):
            if webhook.id not in self._sending:
                task = self._loop.create_task(self._serve(webhook))
                self._sending[webhook.id] = task
                task.add_done_callback(partial(self._ended, webhook.id))

    def _ended(self, webhook: str, task: asyncio.Task[None]) -> None:
        del self._sending[webhook]
        if not task.cancelled() and (fault := task.exception()) is not None:
            _log.error("webhook %s could not be served", webhook, exc_info=fault)

    async def _serve(self, webhook: WebhookRecord) -> None:
        """Send all that is due to a webhook."""
        import httpx  # noqa: PLC0415  (takes a fifth of a second, and few servers have webhooks)

        # Neither proxies of the environment nor redirections: the address was looked at.
        async with httpx.AsyncClient(trust_env=False, timeout=_TIMEOUT) as client:
            while True:
                claim = partial(self._store.claim, webhook.id, self._clock(), _LEASE, _AT_ONCE)
                claimed = await self._ask(claim)
                if not claimed:
                    return
                sends = (self._deliver(client, webhook, *each) for each in claimed)
                if not all(await asyncio.gather(*sends)):
                    return

    async def _deliver(
        self,
        client: "httpx.AsyncClient",
        webhook: WebhookRecord,
        notice: Notice,
        message: Message | None,
    ) -> bool:
        """Send a message, and return whether the webhook took it or it is of no use any more."""
        status, reason = 0, ""
        if message is not None:
            status, reason = await self._send(client, webhook, message)
        if not reason:
            await self._ask(self._store.settle, notice)
            if message is not None:
                await self._ask(self._store.note_success, webhook)
            return True
        await self._ask(self._note_failure, webhook, notice, status, reason)
        return False

    async def _send(
        self, client: "httpx.AsyncClient", webhook: WebhookRecord, message: Message
    ) -> tuple[int, str]:
        """Send a message; return the status of the answer, 0 without one, and what was wrong."""
        import httpx  # noqa: PLC0415

        now, body = self._clock(), message.body
        try:
            async with asyncio.timeout(_TIMEOUT):
                target = await resolve(webhook.url, may_be_private=self._terms.may_be_private)
                headers = {
                    "host": target.host,
                    **signed_headers(message, body, webhook.secret, now),
                }
                known = {"sni_hostname": target.name}
                # The answer's body is not read, however long it is.
                async with client.stream(
                    "POST", target.url, content=body, headers=headers, extensions=known
                ) as answer:
                    status = answer.status_code
        except AddressNotAllowed as fault:
            return 0, fault.detail
        except (OSError, TimeoutError, httpx.HTTPError, httpx.InvalidURL) as fault:
            return 0, f"{type(fault).__name__}: {fault}"[:200]
        return status, "" if 200 <= status < 300 else f"answered {status}"

    def _note_failure(
        self, webhook: WebhookRecord, notice: Notice, status: int, reason: str
    ) -> None:
        """Have a message be sent again, or give it up; disable what has failed for long."""
        now, delays = self._clock(), self._terms.delays
        since = self._store.note_failure(webhook.id, reason, now)
        if status == _GONE or now - since >= timedelta(days=self._terms.failure_days):
            _log.warning("webhook %s is disabled: %s", webhook.id, reason)
            self._store.disable(webhook.id, now)
        elif notice.attempts < len(delays):
            self._store.postpone(notice, now + timedelta(seconds=delays[notice.attempts]))
        else:
            _log.warning(
                "webhook %s never took event %d of %s", webhook.id, notice.number, notice.job
            )
            self._store.settle(notice)
