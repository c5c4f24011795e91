"""benchmarks/mbm.py from end to end, in a process of its own that it may pin."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "benchmarks" / "mbm.py"


def run(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(SCRIPT), *arguments],
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_json_is_one_object_with_every_key(models: Path, problem_file: Path) -> None:
    files = ("--problems", str(problem_file), "--models", str(models))
    done = run(*files, "--limit", "2", "--drake", "1", "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
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


def test_missing_data_is_said_without_a_traceback(tmp_path: Path) -> None:
    done = run("--json", WAYPROOF_MBM=str(tmp_path / "nowhere"))
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.startswith("mbm.py: there are no problems at")
    assert "--problems" in done.stderr
    assert len(done.stderr.splitlines()) == 1
