"""wayproof keys: made, listed, rotated and revoked beside a server, which follows."""

import re

import pytest
from typer.testing import CliRunner

from service.app import create_app
from service.cli.app import app
from service.cli.private_server import KEY_VARIABLE, _environment
from service.cli.session import session
from service.settings import Settings
from tests.service.conftest import TestClient

KEY = re.compile(r"^wp_\w{12}_[\w-]{43}$")


@pytest.fixture
def keys(tmp_path):
    """The command, on a folder that no server has opened yet."""

    def run(*arguments, code=0):
        ended = CliRunner().invoke(app, ["keys", *arguments, "--data-dir", str(tmp_path)])
        assert ended.exit_code == code, ended.output
        assert "Traceback" not in ended.output
        return ended

    return run


def states(keys, capsys):
    """Name and state of every key on the list, which rich writes to the first stdout."""
    capsys.readouterr()
    text = keys("list").stdout + capsys.readouterr().out
    rows = [line.split("│")[1:-1] for line in text.splitlines() if line.startswith("│")]
    assert not re.search(r"wp_|[0-9a-f]{64}", text)
    return [(row[0].strip(), row[-1].strip()) for row in rows if row[-1].strip()]


def test_a_key_is_all_that_goes_to_stdout(keys):
    ended = keys("create", "ci", "--scope", "read", "--scope", "plan", "--days", "30")
    assert KEY.match(ended.stdout.strip())
    assert "plan, read" in ended.stderr
    assert ended.stdout.strip() not in ended.stderr


def test_keys_are_listed_rotated_and_revoked(keys, capsys):
    first = keys("create", "ci", "--scope", "read").stdout
    keys("create", "short", "--scope", "read", "--days", "0")
    second = keys("rotate", "ci").stdout
    assert first != second
    assert states(keys, capsys) == [("ci", "revoked"), ("short", "expired"), ("ci", "valid")]
    keys("rotate", "ci", "--overlap", "1")
    assert states(keys, capsys).count(("ci", "valid")) == 2
    assert len(keys("revoke", "ci").stdout.splitlines()) == 2
    assert {state for _, state in states(keys, capsys)} == {"revoked", "expired"}


@pytest.mark.parametrize(
    ("arguments", "code", "word"),
    [
        (("revoke", "robot-a"), 1, "did you mean 'robot-b'?"),
        (("rotate", "nothing"), 1, "'nothing' does not exist"),
        (("create", "ci", "--scope", "read"), 1, "wayproof keys rotate ci"),
        (("create", "a b", "--scope", "read"), 1, "1 to 64"),
        (("create", "x", "--scope", "root"), 2, "admin"),
        (("create", "x"), 2, "scope"),
    ],
)
def test_mistakes_end_with_a_sentence(keys, arguments, code, word):
    keys("create", "ci", "--scope", "read")
    keys("create", "robot-b", "--scope", "read")
    assert word in keys(*arguments, code=code).stderr


def test_a_database_that_is_none_ends_with_a_sentence(keys, tmp_path):
    (tmp_path / "wayproof.sqlite").write_bytes(b"no database" * 100)
    assert "cannot use the database" in keys("list", code=1).stderr


@pytest.mark.parametrize("url", ["nothing", "sqlite:///{file}/below.sqlite", "x://y"])
def test_so_does_an_address_that_leads_nowhere(keys, url, monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("WAYPROOF_DATABASE_URL", url.format(file=tmp_path / "file"))
    assert "cannot use the database" in keys("list", code=1).stderr


def test_a_server_says_that_there_are_no_keys_yet(keys, tmp_path, caplog):
    settings = Settings(engine="inline", data_dir=tmp_path, auth="keys")
    with TestClient(create_app(settings)):
        assert "wayproof keys create" in caplog.text
    keys("create", "ci", "--scope", "read")
    caplog.clear()
    with TestClient(create_app(settings)):
        assert "wayproof keys create" not in caplog.text


def test_a_private_server_asks_for_no_key_and_gets_none(monkeypatch):
    for name, value in (("AUTH", "keys"), ("RATE_LIMIT", "1/day"), ("API_KEY", "wp_secret")):
        monkeypatch.setenv(f"WAYPROOF_{name}", value)
    chosen = _environment()
    assert (chosen["WAYPROOF_AUTH"], chosen["WAYPROOF_RATE_LIMIT"]) == ("none", "")
    assert KEY_VARIABLE not in chosen


def test_a_server_takes_the_keys_that_were_made(keys, tmp_path):
    text = keys("create", "ci", "--scope", "read").stdout.strip()
    settings = Settings(engine="inline", data_dir=tmp_path, auth="keys")
    with TestClient(create_app(settings)) as client:
        headers = {"Authorization": f"Bearer {text}"}
        assert client.get("/v1/plans", headers=headers).status_code == 200
        keys("revoke", "ci")
        client.portal.call(client.app.state.callers.keys.read)
        assert client.get("/v1/plans", headers=headers).status_code == 401


def test_commands_send_the_key_of_the_environment(monkeypatch):
    monkeypatch.setenv(KEY_VARIABLE, "wp_secret")
    with session("http://127.0.0.1:1") as client:
        assert client._http.headers["authorization"] == "Bearer wp_secret"
    monkeypatch.delenv(KEY_VARIABLE)
    with session("http://127.0.0.1:1") as client:
        assert "authorization" not in client._http.headers
