"""Our errors as JSON texts, from a slot's process to the server and back to what they were."""

import json
import sys
from typing import Any

from planning.errors import PlanningFailure, StageFailure, WayproofError
from service.jobs.json_text import encode_leniently


class RemoteFailure(PlanningFailure):
    """An error whose class the server does not know; it keeps its code, stage and timings."""

    def __init__(self, code: str, stage: str, detail: str, evidence: dict[str, Any]) -> None:
        super().__init__(detail, evidence)
        self.code = code  # pyright: ignore[reportAttributeAccessIssue]
        self.stage = stage


def dump_error(error: WayproofError) -> str:
    """Return the text of an error."""
    kind = type(error)
    known = {
        "module": kind.__module__,
        "name": kind.__qualname__,
        "code": error.code,
        "stage": str(getattr(error, "stage", "")),
        "timings": dict(getattr(error, "timings", {})),
        "detail": error.detail,
    }
    evidence = encode_leniently(error.evidence)
    return f'{encode_leniently(known)[:-1]},"evidence":{evidence}}}'


def load_error(text: str) -> WayproofError:
    """Return the error in a text, of its own class if the server has loaded it."""
    told = json.loads(text)
    evidence = dict(told["evidence"])
    kind = getattr(sys.modules.get(told["module"]), told["name"], None)
    error: WayproofError
    if isinstance(kind, type) and issubclass(kind, WayproofError) and kind.code == told["code"]:
        error = kind(told["detail"], evidence)
    else:
        error = RemoteFailure(told["code"], told["stage"], told["detail"], evidence)
    if isinstance(error, StageFailure):
        error.in_stage(told["stage"]).timings = dict(told["timings"])
    return error
