"""A server that others can reach does not start without keys, unless it is told why."""

import pytest
from typer.testing import CliRunner

from service.app import create_app
from service.cli.app import app
from service.errors import Unguarded
from service.security.start import require_guarded
from service.settings import Settings
from tests.service.conftest import TestClient

LOOPBACK = ["127.0.0.1", "127.1.2.3", "localhost", "::1"]
REACHABLE = ["0.0.0.0", "::", "192.168.1.7", "box", "", "::ffff:127.0.0.1", "127.0.0.1.example.org"]


@pytest.mark.parametrize("host", LOOPBACK)
@pytest.mark.parametrize("auth", ["none", "keys", "proxy"])
def test_loopback_needs_no_keys(host, auth):
    require_guarded(Settings(host=host, auth=auth))


@pytest.mark.parametrize("host", REACHABLE)
def test_what_others_reach_does(host):
    require_guarded(Settings(host=host, auth="keys"))
    require_guarded(Settings(host=host, auth="proxy"))
    with pytest.raises(Unguarded) as refused:
        require_guarded(Settings(host=host))
    assert refused.value.evidence == {"host": host}


def test_the_application_itself_refuses_to_start(tmp_path):
    settings = Settings(engine="inline", host="0.0.0.0", data_dir=tmp_path)
    with pytest.raises(Unguarded), TestClient(create_app(settings)):
        pass
    assert not list(tmp_path.iterdir())


def test_the_sentence_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.delenv("WAYPROOF_AUTH", raising=False)
    arguments = ["--engine", "inline", "--host", "0.0.0.0", "--port", "0"]
    ended = CliRunner().invoke(app, ["serve", *arguments, "--data-dir", str(tmp_path)])
    assert ended.exit_code == 1
    assert "listens" not in ended.output
    (line,) = ended.stderr.strip().splitlines()
    for word in ("WAYPROOF_AUTH=keys", "wayproof keys create", "WAYPROOF_AUTH=proxy", "0.0.0.0"):
        assert word in line
