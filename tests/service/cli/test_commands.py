"""The commands as people run them: a message or a summary, an exit code."""

import csv
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from service.cli.app import app


def wayproof(*arguments):
    """What a process of its own says."""
    command = [sys.executable, "-m", "service", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_plan_works_with_no_server_running(tmp_path):
    out = tmp_path / "motion.csv"
    run = wayproof("plan", "maze_2d", "--to", "exit", "--seed", 2, "--out", out)
    assert run.returncode == 0, run.stderr
    assert "proven" in run.stdout
    rows = list(csv.reader(out.read_text().splitlines()))
    assert rows[0][0] == "time"
    assert len(rows) > 10


def test_the_demo_tells_its_story(real_server, tmp_path):
    run = wayproof("demo", "--out", tmp_path, "--speed", 10, "--server", real_server.url)
    assert run.returncode == 0, run.stderr
    assert "min clearance" in run.stdout
    assert run.stdout.count("succeeded") >= 4
    replays = sorted(path.name for path in tmp_path.glob("*.html"))
    assert replays == ["ur5e_pickup-1-to-pick.html", "ur5e_pickup-2-to-place.html"]


def test_what_the_server_lacks_ends_with_a_message(real_server):
    run = wayproof("plan", "ur5e_pickup", "--to", "pik", "--server", real_server.url)
    assert run.returncode == 1
    assert "pick" in run.stderr
    assert "Traceback" not in run.stderr


@pytest.mark.parametrize(
    ("arguments", "code", "word"),
    [
        (("nowhere", "--to", "pick"), 1, "ur5e_pickup"),
        (("maze_2d", "--to", "exit", "--server", "http://127.0.0.1:1"), 1, "cannot reach"),
        (("maze_2d", "--to", "exit", "--out", "x.png"), 2, ".json"),
    ],
)
def test_mistakes_end_with_a_message(arguments, code, word, capsys):
    ended = CliRunner().invoke(app, ["plan", *arguments])
    assert ended.exit_code == code
    # rich writes to the stream that there was when the console was made
    assert word in ended.stderr + capsys.readouterr().err
    assert isinstance(ended.exception, SystemExit)


def test_help_names_every_command():
    told = CliRunner().invoke(app, ["--help"])
    assert told.exit_code == 0
    for command in ("serve", "plan", "demo"):
        assert command in told.stdout
