"""Checker: what must hold of every job, whatever went wrong while it was done.

It shares no code with the service: it knows only what was asked and what the API says afterwards.
"""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from benchmarks.chaos_rounds.journal import FINAL, Asked, Event, Violation

# How a job may end for what is done to its worker or its server.
LOST = {
    "plan": frozenset({"worker_crashed", "host_lost", "server_restarted", "deadline_exceeded"}),
    "execution": frozenset({
        "worker_crashed",
        "worker_unresponsive",
        "host_lost",
        "server_restarted",
    }),
}
# A plan is given up only when it was lost so often.
_ATTEMPTS = 2
# An execution ends within so much of where it should [rad or m].
_AT_END = 0.005
# A measured position is so near to the planned one at the same time [rad or m].
_ON_PATH = 0.01
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Reference:
    """What the request of a plan gives when nothing goes wrong.

    Attributes:
        job: The plan.
        motion: sha256 of its numbers; empty without one.
    """

    job: dict[str, Any]
    motion: str


@dataclass(frozen=True)
class Seen:
    """A job after the faults.

    Attributes:
        asked: By a client.
        job: As the API shows it.
        again: The id that its key gives when the request is sent again.
        events: All of them.
        motion: sha256 of a plan's numbers; empty without one.
        reference: Of a plan that came to its own end.
        trajectory: Of the plan that an execution carries out.
    """

    asked: Asked
    job: dict[str, Any]
    again: str
    events: Sequence[Event]
    motion: str = ""
    reference: Reference | None = None
    trajectory: Mapping[str, Any] | None = None


type Rule = Callable[[Seen], Iterator[str]]


def check(seen: Sequence[Seen], listed: Mapping[str, Sequence[str]]) -> list[Violation]:
    """Return everything that does not hold.

    Args:
        seen: Every job that was accepted.
        listed: Ids of all jobs there are, by kind, as the API lists them.
    """
    found = [
        Violation(rule, one.asked.id, what)
        for one in seen
        for rule, holds in _RULES.items()
        for what in holds(one)
    ]
    return [*found, *_none_lost_none_doubled(seen, listed), *_one_mover_at_a_time(seen)]


def _one_end(seen: Seen) -> Iterator[str]:
    state = seen.job["state"]
    if state not in FINAL[seen.asked.kind]:
        yield f"is {state}"
    if set(seen.asked.ends) - {state}:
        yield f"is {state}, and was seen as {seen.asked.ends}"
    if seen.job["unrecorded"]:
        yield f"has ended, and {seen.job['unrecorded']} is unrecorded"


def _whole_log(seen: Seen) -> Iterator[str]:
    numbers = [event.number for event in seen.events]
    if numbers != list(range(1, len(numbers) + 1)):
        yield f"has events {numbers}"
    ends = [event for event in seen.events if event.type == "finished"]
    if len(ends) != 1 or seen.events[-1] is not ends[0]:
        yield f"has {len(ends)} events `finished`, the last is {seen.events[-1:]}"
    # A job that fails is an execution that is aborted.
    elif {"failed": "aborted"}.get(ends[0].data["state"], ends[0].data["state"]) != (
        {"failed": "aborted"}.get(seen.job["state"], seen.job["state"])
    ):
        yield f"is {seen.job['state']}, and its log says {ends[0].data}"


def _streamed_as_logged(seen: Seen) -> Iterator[str]:
    streamed = seen.asked.streamed
    if streamed and streamed != list(seen.events):
        known = {event.number: event for event in seen.events}
        odd = [event for event in streamed if event != known.get(event.number)]
        numbers = [event.number for event in streamed]
        yield f"its stream told events {numbers} of {len(known)}; unlike the log: {odd[:3]}"


def _same_key_same_job(seen: Seen) -> Iterator[str]:
    if seen.again != seen.asked.id:
        yield f"its key {seen.asked.key} now gives {seen.again}"


def _known_reason(seen: Seen) -> Iterator[str]:
    kind, job = seen.asked.kind, seen.job
    failure = job["failure"] or {}
    code, evidence = failure.get("code"), failure.get("evidence", {})
    if job["state"] == "canceled":
        by_server = "reason" in evidence
        if not seen.asked.cancels and not (kind == "execution" and by_server):
            yield f"is canceled, which no client asked for: {job['failure']}"
    elif job["state"] in {"failed", "aborted"} and code not in LOST[kind]:
        expected = seen.reference and (seen.reference.job["failure"] or {}).get("code")
        if code != expected:
            yield f"failed with {code}, not {expected}: {job['failure']}"
    elif kind == "plan" and evidence.get("attempts", _ATTEMPTS) < _ATTEMPTS:
        yield f"was given up too early: {job['failure']}"


def _poison_gives_nothing(seen: Seen) -> Iterator[str]:
    if seen.asked.poison and seen.job["state"] == "succeeded":
        yield f"is made to be {seen.asked.poison}, and succeeded"


def _proven(seen: Seen) -> Iterator[str]:
    if seen.asked.kind == "plan" and seen.job["state"] == "succeeded":
        certificate = seen.job["result"]["certificate"]
        if not certificate["proven"] or not all(one["passed"] for one in certificate["checks"]):
            yield f"succeeded with the certificate {certificate}"


def _same_bytes(seen: Seen) -> Iterator[str]:
    if seen.asked.kind != "plan" or seen.job["state"] != "succeeded":
        return
    if seen.reference is None:
        yield "succeeded, and there is no motion"
        return
    job, calm = seen.job, seen.reference.job
    if calm["state"] != "succeeded":
        yield f"succeeded, and is {calm['state']} in calm: {calm['failure']}"
    elif job["result"].get("cut_short") or calm["result"].get("cut_short"):
        return  # a clock had a part in it, and it says so
    elif job["digest"] != calm["digest"]:
        yield f"has the digest {job['digest']}; the same request gives {calm['digest']} in calm"
    elif seen.motion != seen.reference.motion:
        yield "has the digest that the same request gives in calm, and other numbers"
    elif job["result"]["certificate"] != calm["result"]["certificate"]:
        yield "has another certificate than in calm"


def _came_to_its_end(seen: Seen) -> Iterator[str]:
    if seen.asked.kind != "execution" or seen.job["state"] != "succeeded":
        return
    status = seen.job["status"]
    assert seen.trajectory is not None
    gaps = _gaps(status["positions"], seen.trajectory["positions"][-1])
    if status["progress"] < 1.0 or max(gaps) > _AT_END:
        yield f"succeeded at {status['progress']} of its way, {max(gaps):.4f} from its end"


def _stands_on_its_path(seen: Seen) -> Iterator[str]:
    if seen.asked.kind != "execution" or (status := seen.job["status"]) is None:
        return
    assert seen.trajectory is not None
    planned = _at(seen.trajectory, status["time"])
    if (off := max(_gaps(status["positions"], planned))) > _ON_PATH:
        yield f"stands {off:.4f} beside its path at {status['time']:.2f} s"


def _stands_where_it_was_last(seen: Seen) -> Iterator[str]:
    if seen.asked.stood is not None:
        there, told = seen.asked.stood
        if (gap := max(_gaps(there, told))) > _ROUNDING:
            yield f"the scene has the robot {gap:.3g} from where the last status said"
    if seen.job.get("status") is None:
        return
    # What was told and not written when the server was killed is lost, and documented as such.
    kept = [one.time for one in seen.asked.glimpses if one.num_losses == seen.asked.num_losses]
    if kept and max(kept) > seen.job["status"]["time"] + _ROUNDING:
        yield f"ended at {seen.job['status']['time']:.3f} s, and was at {max(kept):.3f} s before"


_RULES: dict[str, Rule] = {
    "every job has one end": _one_end,
    "every log is whole": _whole_log,
    "a stream tells what the log has": _streamed_as_logged,
    "a key gives the same job": _same_key_same_job,
    "every end has a reason": _known_reason,
    "what hangs or crashes gives nothing": _poison_gives_nothing,
    "what succeeds is proven": _proven,
    "the same request gives the same bytes": _same_bytes,
    "what succeeds came to its end": _came_to_its_end,
    "a robot stands on its path": _stands_on_its_path,
    "a robot stands where it was last": _stands_where_it_was_last,
}


def _none_lost_none_doubled(
    seen: Sequence[Seen], listed: Mapping[str, Sequence[str]]
) -> Iterator[Violation]:
    for kind, ids in listed.items():
        asked = [one.asked.id for one in seen if one.asked.kind == kind]
        for identifier in sorted(set(asked) - set(ids)):
            yield Violation("none is lost", identifier, "was accepted, and is not in the list")
        for identifier in sorted(set(ids) - set(asked)):
            yield Violation("none is doubled", identifier, "is in the list, and was not asked for")
        for identifier in sorted({one for one in ids if ids.count(one) > 1}):
            yield Violation("none is doubled", identifier, "is in the list more than once")
        for identifier in sorted({one for one in asked if asked.count(one) > 1}):
            yield Violation("none is doubled", identifier, "was given to two requests")


def _one_mover_at_a_time(seen: Sequence[Seen]) -> Iterator[Violation]:
    by_scene: dict[str, list[dict[str, Any]]] = {}
    for one in seen:
        if one.asked.kind == "execution" and one.job["started_at"] and one.job["finished_at"]:
            by_scene.setdefault(one.job["scene"], []).append(one.job)
    for jobs in by_scene.values():
        jobs.sort(key=lambda job: _instant(job["started_at"]))
        for before, after in itertools.pairwise(jobs):
            if _instant(after["started_at"]) < _instant(before["finished_at"]):
                what = f"began while {before['id']} moved the same robot"
                yield Violation("one moves at a time", after["id"], what)


def _instant(text: str) -> datetime:
    return datetime.fromisoformat(text)


def _gaps(a: Sequence[float], b: Sequence[float]) -> list[float]:
    return [abs(x - y) for x, y in zip(a, b, strict=True)]


def _at(trajectory: Mapping[str, Any], time: float) -> list[float]:
    """Return the planned positions at a time, linearly between samples, one row per instant."""
    times, rows = trajectory["times"], trajectory["positions"]
    after = next((i for i, one in enumerate(times) if one >= time), len(times) - 1)
    before = max(0, after - 1)
    span = times[after] - times[before]
    share = 1.0 if span == 0 else min(1.0, (time - times[before]) / span)
    return [a + share * (b - a) for a, b in zip(rows[before], rows[after], strict=True)]
