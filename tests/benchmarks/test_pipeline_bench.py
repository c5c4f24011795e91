"""`make bench` prints one row for each query, with every stage that a plan reports."""

import json

from benchmarks import pipeline


def test_every_query_is_planned_and_every_stage_is_a_column(monkeypatch, capsys):
    monkeypatch.setattr(pipeline, "QUERIES", (("maze_2d", "body", "exit"),))
    arguments = ["pipeline.py", "--seeds", "1", "--refine", "none", "--json", "--allowed", "60"]
    monkeypatch.setattr("sys.argv", arguments)
    pipeline.main()
    (row,) = json.loads(capsys.readouterr().out)
    assert row["query"] == "maze_2d to exit"
    assert row["failed"] == 0
    assert {stage: len(runs) for stage, runs in row["milliseconds"].items()} == dict.fromkeys(
        pipeline.STAGES, 1
    )
    assert sum(row["milliseconds"]["total"]) > sum(row["milliseconds"]["search"]) > 0
