"""The kernel's benchmark measures both judges on the same questions."""

import math

import benchmarks.kernel
from benchmarks.kernel import BATCHES, beside_rows, measured


def test_every_scene_has_its_rows() -> None:
    rows = list(measured((5,), seed=1, rounds=2))
    assert {row.scene for row in rows} == {"bookshelf", "5 obstacles"}
    for scene in ("bookshelf", "5 obstacles"):
        whats = [row.what for row in rows if row.scene == scene]
        assert whats[: len(BATCHES)] == [f"batches of {size}" for size in BATCHES]
        assert any("edges" in what for what in whats)
    for row in rows:
        assert math.isfinite(row.kernel_us)
        assert row.kernel_us > 0
        assert row.drake_us is not None
        assert row.drake_us > 0
        assert 0 <= row.unsure <= 1
        assert 0 < row.free < 1


def test_drake_has_no_numbers_among_more_obstacles_than_it_loads(monkeypatch) -> None:
    monkeypatch.setattr(benchmarks.kernel, "MAX_OBJECTS_FOR_DRAKE", 4)
    rows = [row for row in measured((5,), seed=1, rounds=2) if row.scene == "5 obstacles"]
    assert rows
    assert all(row.kernel_us > 0 and row.drake_us is None and row.ratio is None for row in rows)


def test_motions_beside_each_other_have_a_row_far_and_near() -> None:
    rows = list(beside_rows(seed=1, rounds=2))
    assert [row.scene for row in rows] == ["two arms, far", "two arms, near"]
    assert all(row.kernel_us > 0 and row.drake_us is not None and row.drake_us > 0 for row in rows)
