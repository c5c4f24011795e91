"""Commands that ask a server, and those that look at this machine: JSON, exit codes, help."""

import json
import re
import socket
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from planning import bundled_folder
from service.cli.app import app
from service.cli.commands import doctor, file_schemas
from service.cli.exit_codes import ExitCode
from service.settings import Settings
from wayproof_client import models

COMMANDS = [
    "serve", "demo", "plan", "execute", "check", "ik", "scenes", "models", "bench", "schema",
    "doctor", "config", "keys", "backup", "restore", "replay",
]  # fmt: skip
PAGE = Path(__file__).parents[3] / "docs" / "reference" / "cli.md"


@pytest.fixture
def ask(real_server):
    """Runs a command against a server; returns its exit code and the JSON on stdout."""

    def run(*arguments):
        words = [*map(str, arguments), "--server", real_server.url, "--json"]
        ended = CliRunner().invoke(app, words)
        assert ended.exception is None or isinstance(ended.exception, SystemExit)
        return ended.exit_code, json.loads(ended.stdout) if ended.stdout else None

    return run


def test_a_plan_is_made_and_carried_out(ask, tmp_path):
    out = tmp_path / "motion.html"
    code, plan = ask("plan", "maze_2d", "--to", "exit", "--seed", 2, "--out", out)
    assert code == 0
    assert models.Plan.model_validate(plan).result.certificate.proven
    assert out.read_text().lstrip().startswith("<!DOCTYPE html>")
    code, execution = ask("execute", plan["id"], "--speed", 20)
    assert (code, execution["state"]) == (0, "succeeded")


def test_a_motion_is_written_as_its_ending_says(ask, tmp_path):
    arguments = ("plan", "panda_shelf", "--to", "ready", "--out", tmp_path / "motion.npz")
    code, plan = ask(*arguments)
    assert code == 0
    with np.load(tmp_path / "motion.npz") as read:
        assert read["times"][-1] == plan["result"]["trajectory"]["duration"]
    assert ask("plan", "maze_2d", "--to", "exit", "--out", tmp_path / "motion.mcap")[0] == 4


def test_a_plan_is_carried_out_where_it_is():
    ended = CliRunner().invoke(app, ["execute", "pln_1"])
    assert ended.exit_code == ExitCode.USAGE
    assert "--server" in ended.stderr


@pytest.mark.parametrize(
    ("where", "code", "is_valid"),
    [
        (("--at", "exit"), ExitCode.SUCCESS, True),
        (("--positions=0.3,-0.18,0",), ExitCode.NO_RESULT, False),
        (("--positions=1,two",), ExitCode.USAGE, None),
        (("--positions=1,nan,0",), ExitCode.USAGE, None),
        (("--positions=1,2,3", "--at", "exit"), ExitCode.USAGE, None),
        (("--at", "nowhere"), ExitCode.USAGE, None),
        (("--positions=1,2",), ExitCode.REFUSED, None),
    ],
)
def test_a_configuration_is_checked(ask, where, code, is_valid):
    ended, found = ask("check", "maze_2d", *where)
    assert ended == code
    assert (found and found["valid"]) == is_valid


def test_configurations_are_found_or_the_reason_is(ask, tmp_path):
    code, found = ask("ik", "ur5e_pickup", "--to", "pick")
    assert code == 0
    assert len(found["configurations"]) > 5
    far = tmp_path / "far.yaml"
    robots = [{"name": "arm", "model": "ur5e", "positions": "home"}]
    frames = [{"name": "far", "parent": "world", "pose": {"position": [9, 0, 0]}}]
    far.write_text(yaml.safe_dump({"name": "far", "robots": robots, "frames": frames}))
    code, found = ask("ik", far, "--to", "far")
    assert code == ExitCode.NO_RESULT
    assert found["failure"]["code"] == "goal_unreachable"


def test_a_bench_counts_and_measures(ask):
    code, found = ask("bench", "maze_2d", "--to", "exit", "--times", 3)
    assert code == 0
    assert (found["plans"], found["succeeded"], found["proven"]) == (3, 3, 3)
    times = found["planning_time"]
    assert 0 < times["min"] <= times["median"] <= times["p95"] <= times["max"]


def test_what_there_is_is_listed(ask, real_server):
    posted = real_server.client.add_scene(b"name: s\nrobots: [{name: arm, model: ur5e}]\n")
    assert ask("scenes")[1][0]["id"] == posted.id
    assert "ur5e" in ask("models")[1]
    assert ask("models", "ur5e")[1]["default_group"] == "arm"
    assert ask("models", "nothing")[0] == ExitCode.REFUSED
    names = [one["name"] for one in json.loads(run("scenes", "--json"))]
    assert "maze_2d" in names


@pytest.mark.parametrize("arguments", [("ik", "ur5e_pickup", "--to", "pick"), ("models", "ur5e")])
def test_people_see_tables(real_server, capsys, arguments):
    ended = CliRunner().invoke(app, [*arguments, "--server", real_server.url])
    assert ended.exit_code == 0
    shown = ended.stdout + capsys.readouterr().out
    assert "┃" in shown
    assert len(shown.splitlines()) < 40


def run(*arguments):
    ended = CliRunner().invoke(app, arguments)
    assert ended.exit_code == 0, ended.output
    return ended.stdout


@pytest.mark.parametrize("command", COMMANDS)
def test_help_loses_nothing(command):
    shown = run(command, "--help")
    assert "Usage" in shown
    assert not re.search(r"[a-z] \.(?!\w)", shown), "a bracket was read as markup"


def test_units_are_in_the_help():
    assert "[s]" in run("plan", "--help")
    assert "[rad or m]" in " ".join(run("check", "--help").replace("│", " ").split())


def test_the_version_is_told():
    assert re.fullmatch(r"wayproof \d+\.\d+\.\d+\n", run("--version"))


def test_the_page_names_every_command_and_every_exit_code():
    text = PAGE.read_text()
    shown = run("--help")
    for command in COMMANDS:
        assert f"`{command}" in text
        assert command in shown
    rows = re.findall(r"^\| (\d+) \|", text, re.MULTILINE)
    assert [int(row) for row in rows] == [*ExitCode, 130]


def test_scenes_are_completed():
    variables = {"_WAYPROOF_COMPLETE": "complete_bash", "COMP_WORDS": "wayproof plan ma"}
    variables |= {"COMP_CWORD": "2"}
    ended = CliRunner().invoke(app, [], env=variables, prog_name="wayproof")
    assert ended.stdout.split() == ["maze_2d", "maze_2d_band"]


@pytest.mark.parametrize(
    ("kind", "pattern", "folder"),
    [("scene", "*.scene.yaml", "scenes"), ("robot", "*/robot.yaml", "models")],
)
def test_schemas_hold_of_what_is_bundled(kind, pattern, folder):
    schema = json.loads(run("schema", kind))
    jsonschema.Draft202012Validator.check_schema(schema)
    found = list(bundled_folder(folder).glob(pattern))
    assert len(found) > 5
    for file in found:
        content = yaml.safe_load(file.read_text())
        jsonschema.validate(content, schema)
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({**content, "nmae": 1}, schema)


def test_bundled_schemas_are_those_of_the_program():
    assert {file: file.read_text() for file in file_schemas.files()} == file_schemas.files()


@pytest.mark.parametrize(
    ("pattern", "folder"), [("*.scene.yaml", "scenes"), ("*/robot.yaml", "models")]
)
def test_bundled_files_name_their_schema(pattern, folder):
    for file in bundled_folder(folder).glob(pattern):
        named = re.match(r"# yaml-language-server: \$schema=(\S+)\n", file.read_text())
        assert named
        assert (file.parent / named[1]).is_file()


def test_a_machine_that_is_well(tmp_path):
    settings = Settings(data_dir=tmp_path / "not" / "there", port=0)
    levels = {one.name: one.level for one in doctor.findings(settings)}
    assert set(levels) >= {"packages", "kernel", "data folder", "disk", "port", "open files"}
    assert "fault" not in levels.values()
    assert not (tmp_path / "not").exists()


def test_a_machine_that_is_not(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("WAYPROOF_DATA_DIR", str(tmp_path / "file"))
    monkeypatch.setenv("WAYPROOF_PLAN_SLOT", "2")
    with socket.create_server(("127.0.0.1", 0)) as other:
        monkeypatch.setenv("WAYPROOF_PORT", str(other.getsockname()[1]))
        ended = CliRunner().invoke(app, ["doctor", "--json"])
    assert ended.exit_code == ExitCode.NO_RESULT
    found = json.loads(ended.stdout)
    assert {one["name"] for one in found if one["level"] == "fault"} == {"data folder", "port"}
    (warning,) = (one for one in found if one["name"] == "settings")
    assert "WAYPROOF_PLAN_SLOTS" in warning["detail"]
