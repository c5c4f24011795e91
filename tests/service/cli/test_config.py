"""`wayproof config` shows what is in force and where it comes from, and names wrong variables."""

import json
import re

import pytest
from typer.testing import CliRunner

from service.cli.app import app
from service.cli.variables import unknown_variables
from service.settings import Settings


@pytest.fixture(autouse=True)
def environment(monkeypatch):
    """An environment without settings, to set some."""
    import os

    for name in [name for name in os.environ if name.startswith("WAYPROOF_")]:
        monkeypatch.delenv(name)
    return monkeypatch.setenv


def config(*arguments):
    return CliRunner().invoke(app, ["config", *arguments])


def shown():
    """The settings by name."""
    found = json.loads(config("--json").stdout)
    return {setting["name"]: setting for setting in found["settings"]}


def test_every_setting_is_shown_with_its_source(environment, tmp_path):
    (tmp_path / "wayproof.toml").write_text("max_queued = 7\nmax_wait = 8.0\n")
    environment("WAYPROOF_CONFIG_FILE", str(tmp_path / "wayproof.toml"))
    environment("WAYPROOF_MAX_WAIT", "9")
    found = shown()
    assert list(found) == list(Settings.model_fields)
    sources = {name: (setting["value"], setting["source"]) for name, setting in found.items()}
    assert sources["max_queued"] == (7, "file")
    assert sources["max_wait"] == (9.0, "environment")
    assert sources["port"] == (8470, "default")
    assert Settings().max_wait == 9.0
    assert Settings(max_queued=5).max_queued == 5


def test_every_setting_says_what_it_is_and_every_amount_its_unit():
    for name, setting in shown().items():
        assert setting["description"], name
        assert "[" not in re.sub(r"`[^`]*`", "", setting["description"]), name
        if isinstance(setting["value"], float):
            assert setting["unit"] in {"s", "days"}, name
        assert setting["variable"] == f"WAYPROOF_{name.upper()}"
    assert shown()["worker_memory"]["unit"] == "bytes"


def test_people_read_the_same():
    text = config().stdout
    for setting in shown().values():
        (line,) = re.findall(rf"^{setting['variable']} = .*", text, re.MULTILINE)
        assert line.endswith("(default)")
        assert setting["description"] in text
    assert "WAYPROOF_MAX_WAIT = 60.0 s  (default)" in text


def test_secrets_are_masked(environment):
    environment("WAYPROOF_DATABASE_URL", "postgresql://robot:HIDDEN@db/plans")
    for arguments in ((), ("--json",)):
        done = config(*arguments)
        assert done.exit_code == 0
        assert "HIDDEN" not in done.output
        assert "postgresql://robot:***@db/plans" in done.stdout


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("WAYPROOF_PLAN_SLOT", "WAYPROOF_PLAN_SLOTS"),
        ("WAYPROOF_DATABASEURL", "WAYPROOF_DATABASE_URL"),
        ("WAYPROOF_LOGFORMAT", "WAYPROOF_LOG_FORMAT"),
        ("wayproof_ports", "WAYPROOF_PORT"),
    ],
)
def test_a_variable_that_is_no_setting_is_named_with_the_nearest(environment, wrong, right):
    environment(wrong, "3")
    done = config()
    assert done.exit_code == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"{wrong} is no setting")
    assert line.endswith(right)
    assert json.loads(config("--json").stdout)["unknown"] == {wrong: right}


def test_variables_of_others_are_no_concern():
    others = ("WAYPROOF_PROFILE", "WAYPROOF_NATIVE", "WAYPROOF_BENCH_PLAN", "HOME", "WAY")
    assert unknown_variables(dict.fromkeys(others, "1")) == {}
    assert unknown_variables({"wayproof_port": "1"}) == {}


def test_serve_warns_of_such_a_variable(environment, tmp_path):
    environment("WAYPROOF_PLAN_SLOT", "3")
    environment("WAYPROOF_DATABASE_URL", "nonsense")  # it ends at once
    command = ["serve", "--engine", "inline", "--port", "0", "--data-dir", str(tmp_path)]
    warning, reason = CliRunner().invoke(app, command).stderr.splitlines()
    assert json.loads(warning)["level"] == "warning"
    assert json.loads(warning)["event"].endswith("WAYPROOF_PLAN_SLOTS")
    assert "database" in reason


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("plan_slot = 3", ["no setting plan_slot", "plan_slots"]),
        ("port = 'x'", ["port", "WAYPROOF_PORT"]),
        ("port = ", ["WAYPROOF_CONFIG_FILE", "TOML"]),
        (None, ["WAYPROOF_CONFIG_FILE", "cannot read"]),
    ],
)
def test_a_file_that_is_wrong_is_refused_in_a_sentence(environment, tmp_path, text, words):
    file = tmp_path / "wayproof.toml"
    if text is not None:
        file.write_text(text)
    environment("WAYPROOF_CONFIG_FILE", str(file))
    done = config()
    assert done.exit_code == 2
    assert isinstance(done.exception, SystemExit)
    (line,) = done.stderr.splitlines()
    assert all(word in line for word in words)


def test_a_value_that_is_wrong_is_named(environment):
    environment("WAYPROOF_MAX_WAIT", "long")
    done = config()
    assert done.exit_code == 2
    assert "WAYPROOF_MAX_WAIT" in done.stderr
