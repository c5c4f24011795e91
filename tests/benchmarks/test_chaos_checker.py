"""The checker of `benchmarks/chaos.py` blames nothing that is well, and each thing that is not."""

import copy
from collections.abc import Callable

import pytest
from sqlalchemy import text

from benchmarks.chaos_rounds.caller import events_in
from benchmarks.chaos_rounds.checker import Reference, Seen, check
from benchmarks.chaos_rounds.databases import Sqlite
from benchmarks.chaos_rounds.disk import SmallDisk
from benchmarks.chaos_rounds.journal import Asked, Event, Glimpse
from benchmarks.chaos_rounds.mix import HANGS, SEGFAULTS
from benchmarks.chaos_rounds.records import check_files, check_rows
from planning.errors import Canceled
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.job import JobSpec
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine

CERTIFICATE = {"proven": True, "checks": [{"name": "clearance", "passed": True}]}
TRAJECTORY = {"times": [0.0, 1.0, 2.0], "positions": [[0.0], [0.5], [1.0]]}
DONE = [
    Event(1, "queued", {}),
    Event(2, "started", {}),
    Event(3, "finished", {"state": "succeeded"}),
]


def plan() -> Seen:
    job = {
        "state": "succeeded",
        "unrecorded": [],
        "failure": None,
        "digest": "d",
        "result": {"certificate": CERTIFICATE, "cut_short": []},
    }
    asked = Asked("plan", "k1", {}, "pln_1", ends=["succeeded"])
    return Seen(asked, job, "pln_1", DONE, "m", Reference(copy.deepcopy(job), "m"))


def motion(name: str, began: int, ended: int) -> Seen:
    job = {
        "id": name,
        "scene": "scn_1",
        "state": "succeeded",
        "unrecorded": [],
        "failure": None,
        "started_at": f"2026-01-01T00:00:{began:02}Z",
        "finished_at": f"2026-01-01T00:00:{ended:02}Z",
        "status": {"progress": 1.0, "time": 2.0, "positions": [1.001]},
    }
    asked = Asked("execution", name, {}, name, ends=["succeeded"], glimpses=[Glimpse(0, 1.0)])
    asked.stood = ([1.001], [1.001])
    return Seen(asked, job, name, DONE, trajectory=TRAJECTORY)


def world() -> list[Seen]:
    return copy.deepcopy([plan(), motion("exe_1", 1, 3), motion("exe_2", 3, 5)])


LISTED = {"plan": ["pln_1"], "execution": ["exe_2", "exe_1"]}


def replaced(place: int, **fields: object) -> Callable[[list[Seen]], None]:
    def change(seen: list[Seen]) -> None:
        seen[place] = Seen(**{**vars(seen[place]), **fields})

    return change


def told(place: int, **fields: object) -> Callable[[list[Seen]], None]:
    return lambda seen: seen[place].job.update(fields)


def asked(place: int, **fields: object) -> Callable[[list[Seen]], None]:
    return lambda seen: vars(seen[place].asked).update(fields)


CRASHED = {"code": "worker_crashed", "evidence": {"attempts": 1}}
WRONG = [
    ("every job has one end", told(0, state="running")),
    ("every job has one end", asked(0, ends=["failed", "succeeded"])),
    ("every job has one end", told(0, unrecorded=["end"])),
    ("every log is whole", replaced(0, events=[*DONE[:2], Event(4, "finished", DONE[2].data)])),
    ("every log is whole", replaced(0, events=[*DONE, Event(4, "finished", DONE[2].data)])),
    ("every log is whole", replaced(0, events=[*DONE, Event(4, "stage", {})])),
    # it ran again, and succeeded twice
    ("every log is whole", replaced(0, events=[*DONE, Event(4, "started", {}), Event(
        5, "finished", DONE[2].data)])),
    ("every log is whole", replaced(0, events=DONE[:2])),
    ("every log is whole", told(0, state="failed", failure=CRASHED)),
    ("a stream tells what the log has", asked(0, streamed=DONE[:2])),
    ("a stream tells what the log has", asked(0, streamed=[DONE[0], *DONE])),
    ("a stream tells what the log has", asked(0, streamed=[DONE[0], Event(2, "x", {}), DONE[2]])),
    ("a key gives the same job", replaced(0, again="pln_2")),
    ("every end has a reason", told(0, state="canceled")),
    ("every end has a reason", told(0, state="failed", failure={"code": "internal_error"})),
    ("every end has a reason", told(0, state="failed", failure=CRASHED)),
    ("every end has a reason", told(1, state="aborted", failure={"code": "tracking_lost"})),
    ("what hangs or crashes gives nothing", asked(0, body={"seed": HANGS})),
    ("what hangs or crashes gives nothing", asked(0, body={"seed": SEGFAULTS})),
    ("what succeeds is proven", told(0, result={"certificate": {**CERTIFICATE, "proven": False}})),
    (
        "what succeeds is proven",
        told(0, result={"certificate": {"proven": True, "checks": [{"passed": False}]}}),
    ),
    ("the same request gives the same bytes", replaced(0, motion="n")),
    ("the same request gives the same bytes", told(0, digest="e")),
    ("the same request gives the same bytes", replaced(0, reference=None)),
    ("the same request gives the same bytes", lambda seen: seen[0].reference.job.update(
        state="failed")),
    ("the same request gives the same bytes", lambda seen: seen[0].reference.job.update(
        result={"certificate": {**CERTIFICATE, "min_clearance": 1.0}})),
    ("what succeeds came to its end", lambda seen: seen[1].job["status"].update(progress=0.9)),
    ("what succeeds came to its end", lambda seen: seen[1].job["status"].update(
        positions=[0.99])),
    ("a robot stands on its path", lambda seen: seen[1].job["status"].update(time=1.5)),
    ("a robot stands where it was last", asked(1, stood=([1.0], [1.001]))),
    ("a robot stands where it was last", asked(1, glimpses=[Glimpse(0, 2.5)])),
    ("none is lost", lambda seen: seen.append(Seen(**{**vars(plan()), "asked": Asked(
        "plan", "k2", {}, "pln_3", ends=["succeeded"]), "again": "pln_3"}))),
    ("none is doubled", lambda seen: seen.pop(0)),
    ("none is doubled", lambda seen: seen.append(seen[0])),
    ("one moves at a time", told(2, started_at="2026-01-01T00:00:02Z")),
]  # fmt: skip


def test_what_is_well_is_not_blamed() -> None:
    assert check(world(), LISTED) == []
    # What was told before a server was killed may be lost, and what is lost to it is told.
    lossy = world()
    asked(1, glimpses=[Glimpse(0, 2.5)], num_losses=2, ends=["aborted"])(lossy)
    told(1, state="aborted", failure={"code": "server_restarted"})(lossy)
    replaced(1, events=[*DONE[:2], Event(3, "finished", {"state": "failed"})])(lossy)
    assert check(lossy, LISTED) == []


def test_what_a_clock_cut_short_need_not_be_the_same_again() -> None:
    seen = world()
    told(0, digest="e", result={"certificate": CERTIFICATE, "cut_short": ["refine"]})(seen)
    assert check(seen, LISTED) == []


@pytest.mark.parametrize(("rule", "change"), WRONG)
def test_what_is_wrong_is_blamed(rule: str, change: Callable[[list[Seen]], object]) -> None:
    seen = world()
    change(seen)
    assert rule in {violation.rule for violation in check(seen, LISTED)}


def test_a_job_that_is_listed_twice_is_blamed() -> None:
    [found] = check(world(), {**LISTED, "plan": ["pln_1", "pln_1"]})
    assert found.rule == "none is doubled"


def test_events_are_read_from_a_stream() -> None:
    first = ": hello\n\nevent: queued\ndata: {}\nid: 1\n\n"
    stream = first + 'event: finished\r\ndata: {"a": 1}\r\nid: 2\n\n'
    assert list(events_in(stream.splitlines())) == [
        Event(1, "queued", {}),
        Event(2, "finished", {"a": 1}),
    ]


SABOTAGE = {
    "UPDATE jobs SET state = 'running'": "every job has one end",
    "DELETE FROM jobs": "every job has one end",
    "DELETE FROM job_bodies": "every log is whole",
    "DELETE FROM job_events WHERE number = 1": "every log is whole",
    "INSERT INTO job_makers VALUES ('pln_9', '{}')": "nothing is left behind",
    "UPDATE job_owner SET is_released = 0": "a server ends when it is told to",
}


@pytest.mark.parametrize("statement", [None, *SABOTAGE])
def test_rows_that_are_wrong_are_blamed(tmp_path, statement: str | None) -> None:
    engine = open_engine(f"sqlite:///{tmp_path / 'wayproof.sqlite'}")
    store, ownership = JobStore(engine), DispatcherLock(engine)
    ownership.take()
    store.open()
    job, _ = store.insert(JobSpec("plan", "x", {}))
    store.cancel_queued(job.id, Canceled("why not"))
    ownership.release()
    if statement is not None:
        with engine.begin() as connection:
            connection.execute(text(statement))
    engine.dispose()
    database = Sqlite(tmp_path, SmallDisk.__new__(SmallDisk))
    try:
        found = check_rows(database, {job.id: "canceled"})
        more = check_rows(database, {})
    finally:
        database.close()
    assert {one.rule for one in found} >= ({SABOTAGE[statement]} if statement else set())
    assert bool(found) is (statement is not None)
    assert statement == "DELETE FROM jobs" or "none is doubled" in {one.rule for one in more}


def test_half_written_files_are_blamed_unless_something_was_killed(tmp_path) -> None:
    known = set()
    assert check_files(tmp_path, known, 0) == []
    (tmp_path / ".part1").mkdir()
    assert [one.rule for one in check_files(tmp_path, set(), 0)] == ["nothing is left behind"]
    assert check_files(tmp_path, known, 1) == []
    assert check_files(tmp_path, known, 0) == []
