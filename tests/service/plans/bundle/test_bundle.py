"""Bundles: what is packed, what is refused, and what comes out when it is planned again."""

import io
import json
import subprocess
import sys
import zipfile
from hashlib import sha256

import pytest
from typer.testing import CliRunner

from service.cli.app import app as commands
from service.cli.exit_codes import ExitCode
from service.plans.bundle.reader import BundleInvalid, read_bundle
from service.plans.bundle.replay import replay_bundle
from service.plans.models.request import PlanRequest


@pytest.fixture(scope="module")
def packed(client, solved):
    """The bundle of a plan that succeeded."""
    answer = client.get(f"/v1/plans/{solved['id']}/bundle.zip")
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/zip"
    assert answer.content == client.get(f"/v1/plans/{solved['id']}/bundle.zip").content
    return answer.content


@pytest.fixture(scope="module")
def failed(client, scene):
    """A plan that failed: its goal hits the post."""
    goal = {"type": "joint", "positions": [0.0] * 6}
    request = {"scene": scene, "group": "arm", "goal": goal}
    return client.post("/v1/plans?wait=60", json=request).json()


def changed(content, changes):
    """A bundle with other entries, or without those that are None."""
    written = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(written, "w") as new:
        entries = {name: old.read(name) for name in old.namelist()} | changes
        for name, entry in entries.items():
            if entry is not None:
                new.writestr(name, entry)
    return written.getvalue()


def entry(content, name):
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return json.loads(archive.read(name))


@pytest.fixture
def stored(tmp_path):
    def store(content):
        path = tmp_path / "bundle.zip"
        path.write_bytes(content)
        return path

    return store


def test_a_bundle_has_what_the_plan_was_made_from(packed, solved):
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        names = archive.namelist()
        urdf = [name for name in names if name.startswith("files/arm/") and "urdf" in name]
        assert urdf
        assert "test_replay.py" in names
        compile(archive.read("test_replay.py"), "test_replay.py", "exec")
    assert PlanRequest.model_validate(entry(packed, "request.json"))
    assert entry(packed, "result.json") == solved["result"]
    manifest = entry(packed, "bundle.json")
    assert (manifest["digest"], manifest["versions"]) == (solved["digest"], solved["versions"])


def test_the_test_in_an_unpacked_bundle_passes_in_a_process_that_knows_nothing(
    packed, stored, tmp_path
):
    folder = tmp_path / "unpacked"
    with zipfile.ZipFile(stored(packed)) as archive:
        archive.extractall(folder)
    assert read_bundle(folder) == read_bundle(stored(packed))
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_replay.py"]
    ended = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=280, check=False
    )
    assert ended.returncode == 0, ended.stdout
    assert "1 passed" in ended.stdout


def test_the_same_bytes_come_out(packed, stored, solved):
    replay = replay_bundle(stored(packed))
    assert replay.is_same, replay.text
    assert replay.found == solved["digest"]
    assert CliRunner().invoke(commands, ["replay", str(stored(packed))]).exit_code == 0


def test_a_failure_comes_again(client, failed, stored):
    assert failed["state"] == "failed"
    content = client.get(f"/v1/plans/{failed['id']}/bundle.zip").content
    assert entry(content, "failure.json")["code"] == failed["failure"]["code"]
    replay = replay_bundle(stored(content))
    assert replay.is_same, replay.text
    assert replay.found == f"failure {failed['failure']['code']}"


def test_the_command_says_what_differs(packed, stored):
    manifest = entry(packed, "bundle.json")
    manifest["digest"] = "0" * 64
    manifest["versions"]["drake"] = "0.1"
    result = entry(packed, "result.json")
    result["trajectory"]["duration"] += 1
    texts = {"bundle.json": json.dumps(manifest), "result.json": json.dumps(result)}
    ended = CliRunner().invoke(commands, ["replay", str(stored(changed(packed, texts))), "--json"])
    assert ended.exit_code == ExitCode.NO_RESULT
    told = json.loads(ended.stdout)
    assert not told["is_same"]
    assert [name for name, _, _ in told["other_versions"]] == ["drake"]
    assert told["differences"][0].startswith("trajectory.duration")


def test_a_file_that_was_changed_is_not_read(packed, stored):
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        [document] = [name for name in archive.namelist() if name.startswith("artifacts/")]
    with pytest.raises(BundleInvalid, match="lacks files"):
        read_bundle(stored(changed(packed, {document: b"{}"})))


def test_no_name_in_an_archive_becomes_a_path(packed, stored, tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("{}")
    work = entry(packed, "work.json")
    work["scene"]["document"] = f"../../{secret}"
    with pytest.raises(BundleInvalid, match="lacks files"):
        read_bundle(stored(changed(packed, {"work.json": json.dumps(work)})))
    escaping = {"files/../../../escaped": b"x", "/files/absolute": b"x"}
    bundle = read_bundle(stored(changed(packed, escaping)))
    assert sha256(b"x").hexdigest() in bundle.artifacts
    assert not list(tmp_path.parent.rglob("escaped"))


@pytest.mark.parametrize(
    "changes",
    [
        {"bundle.json": None},
        {"work.json": None},
        {"bundle.json": b"[" * 100_000},
        {"work.json": b"[]"},
        {"bundle.json": b'{"format": 99}'},
    ],
)
def test_what_is_no_bundle_is_refused(packed, stored, changes):
    path = stored(changed(packed, changes))
    with pytest.raises(BundleInvalid):
        read_bundle(path)
    assert CliRunner().invoke(commands, ["replay", str(path)]).exit_code == ExitCode.USAGE


def test_what_is_too_large_is_refused_whatever_its_header_says(packed, stored):
    bomb = io.BytesIO()
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("files/a", bytes(10_000_000))
    with pytest.raises(BundleInvalid, match="larger"):
        read_bundle(stored(bomb.getvalue()), max_bytes=1_000_000)
    with pytest.raises(BundleInvalid, match="cannot be read"):
        read_bundle(stored(packed[: len(packed) // 2]))


def test_a_plan_that_was_canceled_has_no_bundle(client, scene):
    request = {"scene": scene, "group": "arm", "goal": {"type": "configuration", "name": "ready"}}
    plan = client.post("/v1/plans", json=request).json()
    client.post(f"/v1/plans/{plan['id']}/cancel")
    client.get(f"/v1/plans/{plan['id']}/events")  # until it has ended, canceled or quicker
    ended = client.get(f"/v1/plans/{plan['id']}").json()
    answer = client.get(f"/v1/plans/{plan['id']}/bundle.zip")
    assert answer.status_code == (200 if ended["state"] == "succeeded" else 409)
    assert client.get("/v1/plans/pln_0/bundle.zip").status_code == 404
