"""HostPlan: what a host of workers is told when it begins, and how long each end waits."""

import json
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from typing import Any

from service.jobs.worker.main import Terms
from service.telemetry.logs import LogTerms


@dataclass(frozen=True)
class HostTimeouts:
    """How long the two ends wait for each other [s].

    Attributes:
        patience: At most so long a host waits for news before it answers that there are none.
        lost: A host that has not answered for so long is lost.
        abandoned: A host that was not asked for so long ends what it runs, and itself; less than
            `lost`, so that what is queued again does not run twice for long.
    """

    patience: float = 1.0
    lost: float = 30.0
    abandoned: float = 20.0


@dataclass(frozen=True)
class HostPlan:
    """What a host is told when it begins.

    Attributes:
        preload: Modules that its forkserver imports.
        warm_up: A task that every process runs first.
        workers: The terms of each worker.
        version: Of the program; a host that has another one is not used.
        folder: That the workers of the host share, for copies of artifacts and what is made of
            them, unless the host has one of its own; None if their tasks read none.
        timeouts: How long the ends wait for each other.
    """

    preload: tuple[str, ...]
    warm_up: str | None
    workers: tuple[Terms, ...]
    version: str
    folder: str | None = None
    timeouts: HostTimeouts = field(default_factory=HostTimeouts)

    def dumped(self) -> bytes:
        """Return the plan as JSON."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def loaded(cls, text: bytes) -> "HostPlan":
        """Return the plan that a text is.

        Raises:
            ValueError: It is no JSON.
            KeyError: It lacks something.
            TypeError: The terms of a worker do, or it has what no plan has.
        """
        fields = json.loads(text)
        return cls(
            preload=tuple(fields["preload"]),
            warm_up=fields["warm_up"],
            workers=tuple(_terms(**terms) for terms in fields["workers"]),
            version=fields["version"],
            folder=fields["folder"],
            timeouts=HostTimeouts(**fields["timeouts"]),
        )


def _terms(*, logs: dict[str, Any] | None, **others: Any) -> Terms:
    return Terms(**others, logs=None if logs is None else LogTerms(**logs))


def own_version() -> str:
    """Return the version of the program that is installed here."""
    return version("wayproof")
