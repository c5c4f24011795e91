"""The benchmark of executions measures each section, and tells what failed."""

import json

import pytest

from benchmarks.execution import main
from benchmarks.execution_runs.rows import Row, table_of
from tests.profiles import only_campaign


@pytest.mark.campaign
@only_campaign("a server starts and robots move: 30 s")
def test_everything_is_measured(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--quick", "--json"])  # a busy machine may be slower than asked
    told = json.loads(capsys.readouterr().out)
    assert set(told) == {"tracking", "verdicts", "readers"}
    [tracked] = told["tracking"]
    assert tracked["faults"] == []
    assert 0 < tracked["numbers"]["error mrad or mm"] < 20
    assert [row["what"] for row in told["readers"]] == ["0 readers", "3 readers"]
    assert all(row["faults"] == [] for row in told["readers"])
    assert told["readers"][1]["numbers"]["statuses a reader"] > 5
    verdicts = [fault for row in told["verdicts"] for fault in row["faults"]]
    assert all("took more than" in fault for fault in verdicts)


def test_a_row_without_numbers_is_a_fault_and_a_table_has_all_columns() -> None:
    none, some = Row("none"), Row("some")
    none.note_times([])
    some.note_times([0.001, 0.003])
    assert none.faults == ["nothing was measured"]
    assert some.plain()["numbers"] == pytest.approx({"median ms": 2, "p95 ms": 2.9, "worst ms": 3})
    heads = [column.header for column in table_of("title", [none, some]).columns]
    assert heads == ["what", "median ms", "p95 ms", "worst ms", "failed"]
