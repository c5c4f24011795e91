"""No file of the table ends the one worker that loads them all, and each gets its answer."""

import json
import os
import subprocess
import sys

import pytest

from planning.domain.scene.scene import Scene
from planning.errors import ModelInvalid
from planning.world.documents.scene_file import parse_scene
from planning.world.files import trial_load as trial
from planning.world.models.model_library import ModelLibrary
from tests.service.hostile.files import FILES
from tests.service.hostile.outside_files import OUTSIDE
from tests.service.hostile.test_bodies import tells_of_the_server


@pytest.fixture(scope="module")
def worker(tmp_path_factory):
    """What loads a document, and the folder of its copies."""
    copies = tmp_path_factory.mktemp("copies")
    command = [sys.executable, "-m", "tests.service.hostile.worker", str(copies)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:

        def load(document):
            process.stdin.write(json.dumps(document) + "\n")
            process.stdin.flush()
            line = process.stdout.readline()
            assert line, f"the worker ended: {process.wait()}"
            return json.loads(line)

        load.copies = copies
        yield load
        process.stdin.close()


def scene_of(folder, kind, name):
    model = str(folder / name) if kind == "robot" else "planar_l"
    document = {"name": "s", "robots": [{"name": "r", "model": model}]}
    if kind == "mesh":
        document["objects"] = [{"name": "o", "shape": {"mesh": {"uri": str(folder / name)}}}]
    return document


def write(folder, files):
    for name, content in files.items():
        if callable(content):
            content(folder / name)
        else:
            (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return name


TABLE = FILES | OUTSIDE


@pytest.mark.parametrize("name", TABLE)
def test_the_answer_is_right(worker, tmp_path, name):
    files, code, word = TABLE[name]
    main = write(tmp_path, files)
    answer = worker(scene_of(tmp_path, name.split(":")[0], main))
    if code is None:
        assert answer["status"] == 201, answer["text"]
        return
    failure = json.loads(answer["text"])
    assert (answer["status"], failure["code"]) == (422, code), failure
    assert word in failure["detail"]
    assert main in json.dumps(failure) or {"robot.yaml", "r.srdf"} & set(files)
    assert not tells_of_the_server(answer["text"], worker.copies)
    assert "root:" not in answer["text"]  # as in /etc/passwd


@pytest.fixture
def mesh_scene(tmp_path) -> Scene:
    """A scene with a mesh that nothing is wrong with."""
    files, *_ = FILES["mesh: sound glTF"]
    return parse_scene(scene_of(tmp_path, "mesh", write(tmp_path, files)))


@pytest.fixture
def alone(monkeypatch):
    """A process with one thread, whatever pytest and its plugins have running."""
    monkeypatch.setattr(trial.threading, "active_count", lambda: 1)
    monkeypatch.setattr(trial, "_loadable", set())


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize(
    ("deed", "word"),
    [
        (lambda *_: os.kill(os.getpid(), 11), "ends by SIGSEGV"),
        (lambda *_: os.abort(), "ends by SIGABRT"),
        (lambda *_: os._exit(3), "the process that loads it ends"),
        (lambda *_: bytearray(2**45), "GiB of memory"),
    ],
)
def test_what_a_file_does_to_a_process_is_told(monkeypatch, mesh_scene, tmp_path, deed, word):
    monkeypatch.setattr(trial, "build_single", deed)
    library = ModelLibrary.bundled(copies=tmp_path / "copies")
    with pytest.raises(ModelInvalid, match=word) as refusal:
        trial.trial_load(mesh_scene, library)
    assert refusal.value.evidence["file"] == str(tmp_path / "m.gltf")


@pytest.mark.usefixtures("alone")
def test_what_never_ends_is_ended(monkeypatch, mesh_scene, tmp_path):
    monkeypatch.setattr(trial, "build_single", lambda *_: os.read(os.pipe()[0], 1))
    library = ModelLibrary.bundled(copies=tmp_path / "copies")
    with pytest.raises(ModelInvalid, match="it takes more than"):
        trial.trial_load(mesh_scene, library, time_limit=0.05)


@pytest.mark.usefixtures("alone")
def test_what_loads_is_tried_once(monkeypatch, mesh_scene, tmp_path):
    forks = []
    monkeypatch.setattr(trial, "fork", lambda fork=trial.fork: forks.append(1) or fork())
    library = ModelLibrary.bundled(copies=tmp_path / "copies")
    assert trial.trial_load(mesh_scene, library).files
    trial.trial_load(mesh_scene, library)
    assert forks == [1]
