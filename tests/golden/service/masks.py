"""What of an answer is compared: all of it, but for names, times and the last digits of numbers.

- Ids are numbered as they first come up (`pln_1`), so that answers still say which is which; so are
  sha256 digests (`sha256_1`), but for those of scenes and files, which are of what was posted.
- Secrets are `<secret>`.
- Instants are `<instant>`, members of `timings` and `retry_after` `<seconds>`, versions and the
  kernel `<version>`, and folders what they are for.
- Of an execution, what the simulation measured is `<measured>`, and so is how far it is, unless it
  has succeeded. Of a job that failed or was canceled so is its progress; of one that was canceled
  also what it was doing, and the names of its timings.
- What moves on while it is asked about has its state, stage and instants masked as `<moving>`.
- Numbers are rounded to 6 significant digits and 9 decimals: what is smaller is rounding.
- Of metrics, the names of all and the numbers of jobs are kept.
- Of events, those of type `progress` are left out, and of `status` only the last is kept; so their
  numbers are `<number>`.
"""

import re
from typing import Any

_ID = re.compile(r"\b(scn|pln|reg|exe|bat|whk)_([0-9a-f]{16,32})\b")
_SHA256 = re.compile(r"\b[0-9a-f]{64}\b")
_INSTANT = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|\+00:00)")
_SECRET = re.compile(r"\bwhsec_[A-Za-z0-9+/=]+")
_CANCELED_AT = re.compile(r"canceled [0-9.]+ s into")
_MEASURED = {
    "positions",
    "velocities",
    "torques",
    "path_velocity",
    "tracking_error",
    "max_tracking_error",
    "lateness",
    "jitter",
}
_MOVING = {
    "state",
    "stage",
    "progress",
    "best",
    "status",
    "attempts",
    "cancel_requested_at",
    "started_at",
    "finished_at",
    "unrecorded",
}


class Masks:
    """Masks the answers of one run, in their order."""

    def __init__(self, places: dict[str, str]) -> None:
        """Prepare.

        Args:
            places: Folders, and what is shown for them.
        """
        self._places = places
        self._names: dict[str, str] = {}
        self._counts: dict[str, int] = {}

    def text(self, text: str) -> str:
        """Return a text without ids, digests, instants and places."""
        for place, shown in self._places.items():
            text = text.replace(place, shown)
        text = _ID.sub(lambda found: self._named(found[0], found[1]), text)
        text = _SECRET.sub("<secret>", text)
        text = _SHA256.sub(lambda found: self._named(found[0], "sha256"), text)
        return _CANCELED_AT.sub("canceled <measured> s into", _INSTANT.sub("<instant>", text))

    def document(self, part: Any, *, is_moving: bool = False) -> Any:
        """Return a JSON value as it is compared.

        Args:
            part: The value.
            is_moving: Whether what it is about goes on meanwhile.
        """
        if isinstance(part, dict):
            self._keep_digests(part)
            return {
                self.text(key): _mask(key, part, is_moving=is_moving)
                or self.document(inner, is_moving=is_moving)
                for key, inner in part.items()
            }
        if isinstance(part, list):
            return [self.document(inner, is_moving=is_moving) for inner in part]
        if isinstance(part, float):
            return rounded(part)
        return self.text(part) if isinstance(part, str) else part

    def _keep_digests(self, whole: dict[str, Any]) -> None:
        """Show the digests of scenes and files as they are from now on."""
        kept = list(whole["sha256"].values()) if {"sha256", "named"} <= set(whole) else []
        if {"revision", "digest", "created_at"} <= set(whole) and "request" not in whole:
            kept.append(whole["digest"])
        self._names.update({digest: digest for digest in kept})

    def _named(self, value: str, kind: str) -> str:
        if value not in self._names:
            self._counts[kind] = self._counts.get(kind, 0) + 1
            self._names[value] = f"{kind}_{self._counts[kind]}"
        return self._names[value]


def _mask(key: str, whole: dict[str, Any], *, is_moving: bool) -> Any:
    """Return what is shown for a member of an object, None if nothing has to be hidden."""
    if is_moving and key in _MOVING:
        return "<moving>"
    for mask in (_mask_of_clock, _mask_of_versions, _mask_of_status, _mask_of_ended):
        if (shown := mask(key, whole)) is not None:
            return shown
    return None


def _mask_of_clock(key: str, whole: dict[str, Any]) -> Any:
    if key == "timings":
        is_canceled = "canceled" in (whole.get("state"), whole.get("code"))
        return "<seconds>" if is_canceled else dict.fromkeys(whole[key], "<seconds>")
    return "<seconds>" if key == "retry_after" else None


def _mask_of_versions(key: str, whole: dict[str, Any]) -> Any:
    if key == "versions":
        return dict.fromkeys(whole[key], "<version>")
    is_health = {"version", "kernel"} <= set(whole)
    return "<version>" if is_health and key in {"version", "kernel"} else None


def _mask_of_status(key: str, whole: dict[str, Any]) -> Any:
    if "tracking_error" not in whole:
        return None
    is_open = whole["state"] != "succeeded" and key in {"progress", "time"}
    is_measured = is_open or key in _MEASURED
    return "<measured>" if is_measured and whole[key] is not None else None


def _mask_of_ended(key: str, whole: dict[str, Any]) -> Any:
    if key == "progress" and whole.get("state") in {"failed", "canceled"}:
        return "<measured>"
    if key == "evidence" and whole.get("code") == "canceled":
        return dict.fromkeys(whole[key], "<measured>")
    return None


def rounded(number: float) -> float:
    """Return a number to 6 significant digits and 9 decimals, never -0."""
    return round(float(f"{number:.6g}"), 9) + 0.0


def lasting_events(events: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the events that come in every run: no progress, and the last status."""
    last = next((event for event in reversed(events) if event["event"] == "status"), None)
    left_out = {"progress", "status"}
    return [event for event in events if event["event"] not in left_out or event is last]
