"""Chaos, for real, where there is time for it; its parts, always."""

import os
import random
import signal
import subprocess
import sys

import pytest

from benchmarks.chaos import main, parser, table
from benchmarks.chaos_rounds import keeper
from benchmarks.chaos_rounds.disk import SmallDisk
from benchmarks.chaos_rounds.faults import FaultKind, draw, kinds_of, stopped
from benchmarks.chaos_rounds.fleet import Fleet
from benchmarks.chaos_rounds.journal import Journal, Violation
from benchmarks.chaos_rounds.mix import HANGS, SEGFAULTS
from benchmarks.chaos_rounds.rounds import Round
from benchmarks.serving.processes import descendants
from tests.profiles import only_campaign, seeds

SLEEP = [sys.executable, "-c", "import sys; sys.stdin.read()"]


@pytest.mark.campaign
@only_campaign("servers start a dozen times: a minute")
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("seed", seeds(1, campaign=2))
@pytest.mark.parametrize("database", ["sqlite", "postgresql"])
def test_nothing_is_violated(database: str, seed: int) -> None:
    assert main(["--database", database, "--jobs", "20", "--rounds", "1", "--seed", str(seed)]) == 0


OF_SEVERAL = {FaultKind.LEADER_KILLED, FaultKind.FOLLOWER_KILLED, FaultKind.ALL_KILLED}
OF_ONE = {FaultKind.SERVER_KILLED}
OF_MACHINES = {FaultKind.HOST_KILLED, FaultKind.NODE_KILLED}


@pytest.mark.parametrize(
    ("database", "engine", "num_servers", "left_out"),
    [
        ("postgresql", "process", 1, OF_SEVERAL | OF_MACHINES),
        ("postgresql", "ray", 1, OF_SEVERAL | {FaultKind.FORKSERVER_KILLED}),
        ("postgresql", "process", 2, OF_ONE | OF_MACHINES),
        ("sqlite", "process", 1, OF_SEVERAL | OF_MACHINES | {FaultKind.AWAY}),
    ],
)
def test_a_seed_always_gives_the_same_faults_of_every_kind(
    database: str, engine: str, num_servers: int, left_out: set[FaultKind]
) -> None:
    kinds = kinds_of(database, engine, num_servers)
    first, again = (draw(random.Random(3), 300, kinds) for _ in range(2))
    assert first == again
    assert {fault.kind for fault in first} == set(FaultKind) - left_out


# Each in a process of its own, which a thread of Python's ends as soon as one may run.
POISONED = f"""
import os, signal, threading
from types import SimpleNamespace
from benchmarks.chaos_rounds.poison import plan_or_break
for seed in ({HANGS}, {SEGFAULTS}):
    if (child := os.fork()) == 0:
        threading.Timer(0.05, os._exit, [7]).start()
        plan_or_break(SimpleNamespace(seed=seed))
    threading.Event().wait(0.3)
    os.kill(child, signal.SIGINT)
    threading.Event().wait(0.3)
    os.kill(child, signal.SIGKILL)
    print(os.WTERMSIG(os.waitpid(child, 0)[1]))
"""


def test_poison_lets_nothing_of_python_run_or_breaks_the_process() -> None:
    command = [sys.executable, "-c", POISONED]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert done.stdout.split() == [str(int(signal.SIGKILL)), str(int(signal.SIGSEGV))]


def test_a_process_is_stopped_and_goes_on_and_its_end_is_seen() -> None:
    with subprocess.Popen(SLEEP, stdin=subprocess.PIPE) as child:
        [process] = [one for one, _ in descendants(os.getpid()) if one.pid == child.pid]
        with stopped(process):
            assert os.WIFSTOPPED(os.waitpid(child.pid, os.WUNTRACED)[1])
            assert process.is_alive
        assert os.WIFCONTINUED(os.waitpid(child.pid, os.WCONTINUED)[1])
        process.send(signal.SIGKILL)
        assert child.wait() == -signal.SIGKILL
        assert not process.is_alive


@pytest.mark.skipif(os.getuid() != 0, reason="only root makes files immutable")
def test_what_is_read_only_takes_nothing_even_where_it_is_open(tmp_path) -> None:
    disk = SmallDisk(tmp_path / "disk", 16)
    try:
        if not (tmp_path / "disk.ext4").exists() or not disk.is_real:
            pytest.skip("no file system may be mounted here")
        path = disk.folder / "file"
        with path.open("wb", buffering=0) as file:
            assert file.write(b"a") == 1
            with disk.read_only([path]), pytest.raises(PermissionError):
                file.write(b"b")
            assert file.write(b"c") == 1
        assert path.read_bytes() == b"ac"
        with pytest.raises(OSError, match="gone"), disk.read_only([disk.folder / "gone"]):
            pass
    finally:
        disk.close()


class Ended:
    """A server that has ended, whose processes are those of the tests."""

    pid = os.getpid()

    def end(self) -> int:
        return 0


def test_a_process_that_outlives_its_server_is_blamed(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(keeper, "_GONE_WITHIN", 0.1)
    journal = Journal()
    kept = keeper.Keeper(tmp_path, tmp_path / "log", {}, journal)
    with subprocess.Popen(SLEEP, stdin=subprocess.PIPE) as child:
        kept._server = Ended()
        kept.end()
        kept.check_gone()
        assert child.poll() is None
        child.kill()
    blamed = [one for one in journal.violations if one.job == f"process {child.pid}"]
    assert [one.rule for one in blamed] == ["nothing is left running"]


class Stopped(Ended):
    """A server that has ended by itself."""

    printed = "why"
    url = "http://127.0.0.1:1"

    def __init__(self, code: int) -> None:
        self.code = code

    def listen(self) -> None:
        self.code = None

    def kill(self) -> None:
        pass


@pytest.mark.parametrize(
    ("code", "is_shared", "is_blamed"),
    [(3, True, False), (3, False, True), (1, True, True), (0, True, True)],
)
def test_a_server_that_ends_by_itself_is_started_again(
    tmp_path, monkeypatch, code: int, is_shared: bool, is_blamed: bool
) -> None:
    monkeypatch.setattr(keeper, "Server", lambda *_: Stopped(0))
    journal = Journal()
    kept = keeper.Keeper(tmp_path, tmp_path / "log", {}, journal, is_shared=is_shared)
    kept._server = Stopped(code)
    kept.revive()
    assert kept.url
    assert [one.rule for one in journal.violations] == (
        ["a server ends when it is told to"] if is_blamed else []
    )
    assert kept.stood_down == (not is_blamed)
    kept.revive()
    assert kept.losses == 1


class Somewhere:
    """A server's place: it is there, or it is not."""

    def __init__(self, url: str) -> None:
        self.url = url
        self.losses = 1


def test_clients_talk_to_each_server_that_is_there() -> None:
    fleet = Fleet([Somewhere("a"), Somewhere(""), Somewhere("b")])
    assert {fleet.url for _ in range(2)} == {"a", "b"}
    assert fleet.losses == 3
    assert Fleet([Somewhere("")]).url == ""


def test_a_process_that_ends_with_its_server_is_not_blamed(tmp_path) -> None:
    journal = Journal()
    kept = keeper.Keeper(tmp_path, tmp_path / "log", {}, journal)
    with subprocess.Popen(SLEEP, stdin=subprocess.PIPE) as child:
        kept._server = Ended()
        kept.end()
        child.kill()
        child.wait()
        kept.check_gone()
    assert [one for one in journal.violations if one.job == f"process {child.pid}"] == []


def test_the_table_has_what_happened() -> None:
    assert parser().parse_args([]).jobs == 200
    violation = Violation("none is lost", "pln_1", "was accepted, and is not in the list")
    counts = {FaultKind.SERVER_KILLED: 2}
    ended = {"plan succeeded": 9}
    made = table([Round("sqlite 1", 9, counts, 1, 0, ended, {}, [violation], 3.0)], 4)
    cells = [next(iter(column.cells)) for column in made.columns]
    assert cells[0] == "sqlite 1"
    assert "2 server -9" in cells[3]
    assert "1 start refused" in cells[3]
    assert cells[-1] == "1"
