"""Our errors as JSON texts, from a slot's process to the server and back to what they were."""

import json
import sys
from typing import Any

from planning.errors import PlanningFailure, WayproofError
from service.jobs.json_text import encode_leniently


class RemoteFailure(PlanningFailure):
    """An error whose class the server does not know; it keeps its code and stage."""

    def __init__(self, code: str, stage: str, detail: str, evidence: dict[str, Any]) -> None:
        super().__init__(detail, evidence)
        self.code = code  # pyright: ignore[reportAttributeAccessIssue]
        self.stage = stage  # pyright: ignore[reportAttributeAccessIssue]


def error_text(error: WayproofError) -> str:
    """Return the text of an error."""
    kind = type(error)
    known = {
        "module": kind.__module__,
        "name": kind.__qualname__,
        "code": error.code,
        "stage": str(getattr(error, "stage", "")),
        "detail": error.detail,
    }
    evidence = encode_leniently(error.evidence)
    return f'{encode_leniently(known)[:-1]},"evidence":{evidence}}}'


def error_in(text: str) -> WayproofError:
    """Return the error in a text, of its own class if the server has loaded it."""
    told = json.loads(text)
    evidence = dict(told["evidence"])
    kind = getattr(sys.modules.get(told["module"]), told["name"], None)
    if isinstance(kind, type) and issubclass(kind, WayproofError) and kind.code == told["code"]:
        return kind(told["detail"], evidence)
    return RemoteFailure(told["code"], told["stage"], told["detail"], evidence)
