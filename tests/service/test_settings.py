"""Settings come from arguments and the environment; files are refused to strangers."""

from pathlib import Path

import pytest
from pydantic import ValidationError
from typer.testing import CliRunner

from service.cli.app import app
from service.settings import Settings

GUIDE = Path(__file__).parents[2] / "docs" / "how-to" / "operations.md"


def test_environment_is_read(monkeypatch, tmp_path):
    monkeypatch.setenv("WAYPROOF_PORT", "1234")
    monkeypatch.setenv("WAYPROOF_DATA_DIR", str(tmp_path))
    chosen = Settings()
    assert chosen.port == 1234
    assert chosen.url == f"sqlite:///{tmp_path}/wayproof.sqlite"


def test_arguments_win_over_the_environment(monkeypatch):
    monkeypatch.setenv("WAYPROOF_PORT", "1234")
    assert Settings(port=5).port == 5


def test_state_folder_follows_xdg(monkeypatch, tmp_path):
    monkeypatch.delenv("WAYPROOF_DATA_DIR", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert Settings().data_dir == tmp_path / "wayproof"


@pytest.mark.parametrize(
    ("host", "allowed"),
    [("127.0.0.1", True), ("localhost", True), ("::1", True), ("0.0.0.0", False), ("box", False)],
)
def test_paths_are_for_loopback_only(host, allowed):
    assert Settings(host=host).may_load_paths is allowed
    assert Settings(host=host, allow_model_paths=True).may_load_paths
    assert not Settings(host=host, allow_model_paths=False).may_load_paths


@pytest.mark.parametrize("wrong", [{"port": 70000}, {"engine": "x"}, {"plan_slots": 0}, {"x": 1}])
def test_nonsense_is_refused(wrong):
    with pytest.raises(ValidationError):
        Settings(**wrong)


def test_the_guide_and_the_help_name_every_setting(monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    told = CliRunner().invoke(app, ["serve", "--help"]).stdout
    guide = GUIDE.read_text()
    for name, setting in Settings.model_fields.items():
        variable = f"WAYPROOF_{name.upper()}"
        assert variable in told
        (row,) = [line for line in guide.splitlines() if line.startswith(f"| `{variable}`")]
        if isinstance(setting.default, str | int | float):
            assert str(setting.default).removesuffix(".0").lower() in row.lower()
    assert ".local/state/wayproof" in told
    assert ".local/state/wayproof" in guide


def test_folders_of_robots_are_a_json_list(monkeypatch):
    monkeypatch.setenv("WAYPROOF_MODEL_ROOTS", '["/srv/robots"]')
    assert Settings().model_roots == (Path("/srv/robots"),)


def test_a_cluster_needs_its_address_and_the_extra(monkeypatch):
    with pytest.raises(ValidationError, match="needs ray_address"):
        Settings(engine="ray")
    with pytest.raises(ValidationError, match="ray_address"):
        Settings(engine="ray", ray_address="http://head:6379")
    monkeypatch.setattr("service.settings.find_spec", lambda _: None)
    with pytest.raises(ValidationError, match="needs the extra"):
        Settings(engine="ray", ray_address="head:6379")
