"""Key: by what a client says that two requests are one, and what it then stands for."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class IdempotencyKey:
    """An idempotency key, or none, and all that must be the same where it is used again.

    Attributes:
        text: As the client chose it, or None.
        fingerprint: Whatever tells this request from another one of its lane, JSON-compatible: the
            body as it was sent, and what its address named.
    """

    text: str | None
    fingerprint: Mapping[str, Any]

    @property
    def digest(self) -> str:
        """Return the sha256 of what it stands for."""
        return hashlib.sha256(json.dumps(self.fingerprint, sort_keys=True).encode()).hexdigest()
