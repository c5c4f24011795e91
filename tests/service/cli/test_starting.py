"""A server that cannot start says why in a sentence; one that can says where, once it listens."""

import os
import socket
import sys

import pytest
from typer.testing import CliRunner

from service.cli.app import app
from service.cli.serve import bind
from service.cli.server import run
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.store.sql.database import open_engine
from service.settings import Settings


@pytest.fixture
def settings(tmp_path):
    return Settings(engine="inline", data_dir=tmp_path, port=0, log_level="error")


def serve(*arguments):
    return CliRunner().invoke(app, ["serve", "--engine", "inline", *map(str, arguments)])


def said(ended, code):
    """The one sentence of a command that ended with a code."""
    assert ended.exit_code == code, ended.output
    assert isinstance(ended.exception, SystemExit)
    assert "Traceback" not in ended.output
    assert "listens" not in ended.output
    (line,) = ended.stderr.strip().splitlines()
    return line


def test_a_data_folder_in_use(settings, tmp_path):
    ownership = DispatcherLock(open_engine(settings.url))
    ownership.take()
    try:
        line = said(serve("--port", 0, "--data-dir", tmp_path), 1)
    finally:
        ownership.release()
    assert "another server works on" in line


def test_a_data_folder_that_is_a_file(tmp_path):
    (tmp_path / "file").touch()
    assert "cannot use" in said(serve("--port", 0, "--data-dir", tmp_path / "file"), 1)


def test_a_port_that_is_taken(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as other:
        line = said(serve("--port", other.getsockname()[1], "--data-dir", tmp_path), 1)
    assert "cannot listen on 127.0.0.1" in line


def test_a_port_that_is_taken_while_the_server_starts(tmp_path, monkeypatch):
    from service.cli import serve as module

    bound = bind("127.0.0.1", 0)
    other = bind("127.0.0.1", bound.getsockname()[1])
    monkeypatch.setattr(module, "bind", lambda *_: bound)
    with other:
        other.listen()
        assert "cannot listen" in said(serve("--port", 0, "--data-dir", tmp_path), 1)


@pytest.mark.parametrize(
    ("variable", "value", "word"),
    [
        ("WAYPROOF_PORT", "70000", "port"),
        ("WAYPROOF_MODEL_ROOTS", "foo", "model_roots"),
        ("WAYPROOF_PLAN_SLOTS", "none", "plan_slots"),
    ],
)
def test_settings_that_are_none(monkeypatch, variable, value, word):
    monkeypatch.setenv(variable, value)
    assert word in said(serve(), 2)


def test_a_database_that_is_none(monkeypatch, tmp_path):
    monkeypatch.setenv("WAYPROOF_DATABASE_URL", "nonsense")
    assert "database" in said(serve("--port", 0, "--data-dir", tmp_path), 1)


@pytest.mark.parametrize(
    "arguments",
    [
        ("plan", "maze_2d", "--to", "exit", "--seconds", "nan"),
        ("plan", "maze_2d", "--to", "exit", "--seconds", "-1"),
        ("plan", "maze_2d", "--to", "exit", "--seed", "-1"),
        ("demo", "--speed", "inf"),
    ],
)
def test_numbers_that_are_none(arguments):
    ended = CliRunner().invoke(app, list(arguments))
    assert ended.exit_code == 2
    assert isinstance(ended.exception, SystemExit)
    assert arguments[-2] in ended.output


def test_it_says_that_it_listens_once_it_does(settings, monkeypatch):
    read, write = os.pipe()
    stdin = os.fdopen(read)
    monkeypatch.setattr(sys, "stdin", stdin)
    bound = bind("127.0.0.1", 0)
    address = bound.getsockname()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(address)
    reached = []

    def on_listening():
        with socket.create_connection(address):
            reached.append(True)
        os.close(write)

    with stdin:
        run(settings, bound, leashed=True, on_listening=on_listening)
    assert reached == [True]
