"""Chaos, for real, where there is time for it; its parts, always."""

import os
import random
import signal
import subprocess
import sys

import pytest

from benchmarks.chaos import main, parser, table
from benchmarks.chaos_rounds import keeper
from benchmarks.chaos_rounds.faults import FaultKind, draw, stopped
from benchmarks.chaos_rounds.journal import Journal, Violation
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


def test_a_seed_always_gives_the_same_faults_of_every_kind() -> None:
    first, again = (draw(random.Random(3), 300, "postgresql") for _ in range(2))
    assert first == again
    assert {fault.kind for fault in first} == set(FaultKind) - {FaultKind.HOST_KILLED}
    of_hosts = {fault.kind for fault in draw(random.Random(3), 300, "postgresql", "ray")}
    assert of_hosts == set(FaultKind) - {FaultKind.FORKSERVER_KILLED}
    assert FaultKind.AWAY not in {fault.kind for fault in draw(random.Random(3), 300, "sqlite")}


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
    made = table([Round("sqlite 1", 9, counts, 1, {"plan succeeded": 9}, {}, [violation], 3.0)], 4)
    cells = [next(iter(column.cells)) for column in made.columns]
    assert cells[0] == "sqlite 1"
    assert "2 server -9" in cells[3]
    assert "1 start refused" in cells[3]
    assert cells[-1] == "1"
