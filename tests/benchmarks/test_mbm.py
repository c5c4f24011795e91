"""benchmarks/mbm.py from end to end, but for what pins its process."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import mbm
from benchmarks.motion_bench_maker.command import bench
from tests.clocks import FakeClock
from tests.profiles import only_campaign

ROOT = Path(__file__).parents[2]


@only_campaign("8 s")
def test_json_is_one_object_with_every_key(
    models: Path, problem_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = ("--problems", str(problem_file), "--models", str(models))
    options = mbm.parser().parse_args([*files, "--limit", "2", "--drake", "1", "--json"])
    bench(options, 0, FakeClock(step=1e-6))
    document = json.loads(capsys.readouterr().out)
    for part in (document, document["pose"]):
        assert [part[key] for key in ("problems", "valid", "solved", "free")] == [2, 1, 1, 1]
        assert set(part["total_ms"]) == {"median", "mean", "p95"}
        assert part["total_ms"]["median"] > sum(part["stages_ms"].values()) > 0
        assert {"goals", "search", "refine", "retime", "certify"} <= set(part["stages_ms"])
        assert part["duration_s"]["median"] > 0
        assert part["failures"] == part["not_free"] == []

    # The first joint turns by 1.4 rad, which no path to the goal configuration does in less.
    assert document["length"]["median"] >= 1.4
    assert document["duration_s"]["median"] >= 1.4 / 2.175


def test_missing_data_is_said_without_a_traceback(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WAYPROOF_MBM", str(tmp_path / "nowhere"))
    with pytest.raises(SystemExit) as ended:
        mbm.run(mbm.parser().parse_args(["--json"]), 0)
    assert ended.value.code.startswith("mbm.py: there are no problems at")
    assert "--problems" in ended.value.code
    assert len(ended.value.code.splitlines()) == 1


@pytest.mark.campaign
@only_campaign("imports all engines anew")
def test_the_script_pins_its_process_and_fails_in_one_line(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(ROOT / "benchmarks" / "mbm.py"), "--json"],
        cwd=tmp_path,
        env={**os.environ, "WAYPROOF_MBM": str(tmp_path / "nowhere")},
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("mbm.py: there are no problems at")
    assert len(done.stderr.splitlines()) == 1
