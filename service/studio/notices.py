"""Notices: what a browser is told in a corner of the page."""

from contextlib import suppress

import httpx
import viser

from service.client.errors import ApiError
from service.studio.api import evidence_of
from service.studio.plans.failure_words import headline, plain

_MAX_TEXT = 400
_SECONDS = 12.0


class Notices:
    """The corner of one browser."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """Say nothing yet.

        Args:
            client: The browser.
        """
        self._client = client
        self._away: viser.NotificationHandle | None = None

    def tell(self, fault: Exception) -> None:
        """Say what went wrong."""
        title, body = "Something went wrong", str(fault)
        if isinstance(fault, ApiError):
            code, detail = fault.problem.code, fault.problem.detail
            title = headline(code, detail, evidence_of(fault))
            body = code if title.lower() == plain(detail).lower() else f"{code}: {plain(detail)}"
        elif isinstance(fault, httpx.TransportError):
            title, body = "The server does not answer", "It is asked again with the next click."
        with suppress(Exception):  # the browser has left
            self._client.add_notification(
                title, body[:_MAX_TEXT], color="red", auto_close_seconds=_SECONDS
            )

    def tell_presence(self, is_there: bool) -> None:  # noqa: FBT001  (a callback of one value)
        """Say that the server is gone, as long as it is."""
        with suppress(Exception):
            if self._away is not None:
                self._away.remove()
                self._away = None
            if not is_there:
                self._away = self._client.add_notification(
                    "The server does not answer",
                    "The page goes on once it does.",
                    color="red",
                    loading=True,
                    with_close_button=False,
                )
