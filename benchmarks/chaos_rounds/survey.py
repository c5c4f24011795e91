"""Survey: asks a server in calm for everything that is known of the jobs that it was given."""

import hashlib
import json
from collections.abc import Iterable, Iterator
from contextlib import suppress
from typing import Any

from benchmarks.chaos_rounds.caller import Caller, GaveUp, events_in
from benchmarks.chaos_rounds.checker import LOST, Reference, Seen
from benchmarks.chaos_rounds.journal import Asked, Journal

_PAGE = 200


class Survey:
    """Asks; what it has to plan anew it counts as asked.

    Attributes:
        extra: Ids of the plans that were made for comparison.
    """

    def __init__(self, caller: Caller, journal: Journal) -> None:
        """Ask through `caller`."""
        self.extra: list[str] = []
        self._caller = caller
        self._journal = journal
        self._references: dict[str, Reference] = {}

    def seen(self, asked: Iterable[Asked]) -> Iterator[Seen]:
        """Yield everything that is known of each job; what is not to be had is in the journal."""
        for one in asked:
            with suppress(GaveUp):
                yield self._of(one)

    def _of(self, one: Asked) -> Seen:
        path = f"/v1/{one.kind}s"
        job = self._caller.get(f"{path}/{one.id}")
        again = self._caller.ask("POST", path, one.body, key=one.key).json()
        log = self._caller.ask("GET", f"{path}/{one.id}/events").iter_lines()
        return self._with_motion(Seen(one, job, str(again.get("id")), list(events_in(log))))

    def listed(self, kind: str) -> list[str]:
        """Return the ids of all jobs of a kind, those for comparison left out."""
        found: list[str] = []
        cursor = ""
        while True:
            page = self._caller.get(f"/v1/{kind}s?limit={_PAGE}{cursor}")
            found += [item["id"] for item in page["items"] if item["id"] not in self.extra]
            if page["next"] is None:
                return found
            cursor = f"&cursor={page['next']}"

    def _with_motion(self, seen: Seen) -> Seen:
        job, state = seen.job, seen.job["state"]
        parts = (seen.asked, job, seen.again, seen.events)
        if seen.asked.kind == "execution":
            plan = self._caller.get(f"/v1/plans/{job['request']['plan']}")
            return Seen(*parts, trajectory=plan["result"]["trajectory"])
        is_own_end = state == "succeeded" or (state == "failed" and not _is_lost(job))
        if not is_own_end or job["request"]["search"]["attempts"] > 1:
            return seen
        return Seen(*parts, motion=_motion(job), reference=self._reference(job["request"]))

    def _reference(self, request: dict[str, Any]) -> Reference:
        """Return what a request gives now that nothing goes wrong."""
        key = json.dumps(request, sort_keys=True)
        if key not in self._references:
            job = self._caller.ask("POST", "/v1/plans?wait=60", request).json()
            self.extra.append(job["id"])
            self._references[key] = Reference(job, _motion(job))
        return self._references[key]


def _motion(job: dict[str, Any]) -> str:
    """Return the digest of the numbers that a plan delivers.

    What is proven of the samples is left out: a clock ends these proofs, on a busy machine sooner.
    """
    if job["state"] != "succeeded":
        return ""
    result = job["result"]
    trajectory = {**result["trajectory"], "interpolations": None}
    text = json.dumps([result["path"], trajectory], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _is_lost(job: dict[str, Any]) -> bool:
    return job["failure"]["code"] in LOST["plan"]
