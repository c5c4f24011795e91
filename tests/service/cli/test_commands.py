"""The commands as people run them: no server running, a message or a summary, an exit code."""

import csv
import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow


def wayproof(*arguments):
    command = [sys.executable, "-m", "service", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.timeout(120)
def test_plan_works_with_no_server_running(tmp_path):
    out = tmp_path / "motion.csv"
    run = wayproof("plan", "ur5e_pickup", "--to", "pick", "--seed", 2, "--out", out)
    assert run.returncode == 0, run.stderr
    assert "proven" in run.stdout
    rows = list(csv.reader(out.read_text().splitlines()))
    assert rows[0][0] == "time"
    assert len(rows) > 10


@pytest.mark.timeout(120)
def test_the_demo_tells_its_story(tmp_path):
    run = wayproof("demo", "--out", tmp_path, "--speed", 10)
    assert run.returncode == 0, run.stderr
    assert "min clearance" in run.stdout
    assert run.stdout.count("succeeded") >= 4
    replays = sorted(path.name for path in tmp_path.glob("*.html"))
    assert replays == ["ur5e_pickup-1-to-pick.html", "ur5e_pickup-2-to-place.html"]


@pytest.mark.timeout(120)
@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("plan", "ur5e_pickup", "--to", "pik"), "pick"),
        (("plan", "nowhere", "--to", "pick"), "ur5e_pickup"),
        (("plan", "maze_2d", "--to", "exit", "--server", "http://127.0.0.1:1"), "cannot reach"),
        (("plan", "maze_2d", "--to", "exit", "--out", "x.png"), ".json"),
    ],
)
def test_mistakes_end_with_a_message(arguments, word):
    run = wayproof(*arguments)
    assert run.returncode != 0
    assert word in run.stderr
    assert "Traceback" not in run.stderr


def test_help_names_every_command():
    told = wayproof("--help").stdout
    for command in ("serve", "plan", "demo"):
        assert command in told
