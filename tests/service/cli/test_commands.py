"""The commands as people run them: a message or a summary, an exit code."""

import csv
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from service.cli.app import app
from tests.profiles import only_campaign
from tests.world.meshcat_messages import overlay, tracks


def wayproof(*arguments):
    """What a process of its own says."""
    command = [sys.executable, "-m", "service", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@only_campaign("11 s")
def test_plan_works_with_no_server_running(tmp_path):
    out = tmp_path / "motion.csv"
    run = wayproof("plan", "maze_2d", "--to", "exit", "--seed", 2, "--out", out)
    assert run.returncode == 0, run.stderr
    assert "proven" in run.stdout
    rows = list(csv.reader(out.read_text().splitlines()))
    assert rows[0][0] == "time"
    assert len(rows) > 10


@only_campaign("16 s")
def test_the_demo_shows_what_was_executed(real_server, tmp_path):
    run = wayproof("demo", "--out", tmp_path, "--speed", 10, "--server", real_server.url)
    assert run.returncode == 0, run.stderr
    assert "min clearance" in run.stdout
    (file,) = tmp_path.iterdir()
    assert file.name == "ur5e_pickup.html"
    page = file.read_text()
    titles = [section["title"] for section in overlay(page)["sections"]]
    assert titles == [
        "approach", "close", "lift", "carry", "place", "open", "retreat", "go home"
    ]  # fmt: skip
    moved = tracks(page)
    can, hand = moved["/bodies/can"], moved["/bodies/arm/hand_base"]
    grasps = np.linalg.inv(hand) @ can
    carried = np.flatnonzero(np.abs(np.diff(can, axis=0)).max(axis=(1, 2)) > 1e-6)
    begin, end = carried[0], carried[-1] + 1
    # from where it stood, up, over the box, and to where it belongs
    np.testing.assert_allclose(can[0, :3, 3], (0.5, 0.3, 0.0605), atol=1e-6)
    np.testing.assert_allclose(can[-1, :3, 3], (0.5, -0.28, 0.0605), atol=1e-3)
    assert can[begin:end, 2, 3].max() > 0.3
    np.testing.assert_allclose(
        grasps[begin : end + 1],
        np.broadcast_to(grasps[begin], grasps[begin : end + 1].shape),
        atol=1e-5,
    )
    fingers = [
        np.linalg.inv(hand) @ moved[f"/bodies/arm/{side}_finger"] for side in ("left", "right")
    ]
    gaps = fingers[0][:, 1, 3] - fingers[1][:, 1, 3]
    # the fingers are around it while it moves, and open before and after
    np.testing.assert_allclose(gaps[begin:end], 2 * 0.0202, atol=1e-4)
    np.testing.assert_allclose(gaps[[0, -1]], 2 * 0.025, atol=1e-4)


@pytest.mark.parametrize(
    ("arguments", "code", "word"),
    [
        (("nowhere", "--to", "pick"), 2, "ur5e_pickup"),
        (("maze_2d", "--to", "exit", "--server", "http://127.0.0.1:1"), 5, "cannot reach"),
        (("maze_2d", "--to", "exit", "--out", "x.png"), 2, ".json"),
    ],
)
def test_mistakes_end_with_a_message(arguments, code, word, capsys):
    check_told(arguments, code, word, capsys)


def test_what_the_server_lacks_ends_with_a_message(real_server, capsys):
    arguments = ("ur5e_pickup", "--to", "pik", "--server", real_server.url)
    check_told(arguments, 2, "pick", capsys)


def check_told(arguments, code, word, capsys):
    """A plan ends with this exit code and this word in a message, and no traceback."""
    ended = CliRunner().invoke(app, ["plan", *arguments])
    assert ended.exit_code == code
    # rich writes to the stream that there was when the console was made
    told = ended.stderr + capsys.readouterr().err
    assert word in told
    assert "Traceback" not in told
    assert isinstance(ended.exception, SystemExit)


def test_help_names_every_command():
    told = CliRunner().invoke(app, ["--help"])
    assert told.exit_code == 0
    for command in ("serve", "plan", "demo", "keys"):
        assert command in told.stdout
