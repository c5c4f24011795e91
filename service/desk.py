"""Desk: where endpoints hand in jobs and questions."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any


@dataclass(frozen=True)
class JobView:
    id: str
    serial: int
    state: str
    stage: str
    progress: float
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    payload: dict[str, Any]
    result: dict[str, Any] | None
    failure: dict[str, Any] | None
    is_cancel_requested: bool

    @property
    def is_final(self) -> bool:
        return self.state in {"succeeded", "failed", "canceled"}
