"""Execution states to the wire."""

from typing import Any

from planning.domain.geometry.body_pair import BodyPair
from planning.execute.status import ExecutionStatus
from service.api.models import listed


class StatusLog:
    """Turns statuses into wire form and remembers the worst: contacts, tracking errors, delays."""

    def __init__(self) -> None:
        """Remember nothing yet."""
        self._max_error = 0.0
        self._lateness = 0.0
        self._contacts: dict[tuple[str, str], dict[str, Any]] = {}

    def late(self, seconds: float) -> None:
        """Note that a look at the clock came so much later than it was due [s]."""
        self._lateness = max(self._lateness, seconds)

    def wire(self, status: ExecutionStatus) -> dict[str, Any]:
        """Return the data of a `status` event."""
        self._max_error = max(self._max_error, status.tracking_error)
        for contact in status.contacts:
            self._contacts.setdefault(contact.bodies, contact_wire(contact, status.time))
        return {
            "state": str(status.state),
            "progress": min(1.0, max(0.0, status.progress)),
            "time": status.time,
            "positions": listed(status.measured),
            "tracking_error": status.tracking_error,
            "max_tracking_error": self._max_error,
            "lateness": self._lateness,
            "contacts": list(self._contacts.values()),
        }


def contact_wire(contact: BodyPair, time: float) -> dict[str, Any]:
    """Return a contact for the wire."""
    return {"bodies": list(contact.bodies), "depth": max(0.0, -contact.distance), "time": time}
