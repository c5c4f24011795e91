"""Scenes keep the files that they were made from: posted again after an edit they are others."""

import json
import shutil
import warnings

import pytest
from sqlalchemy import create_engine, delete, select, update

from service.app import create_app
from service.jobs.json_text import Encoded, encode, encode_in_parts
from service.jobs.store.artifact_store import read_content
from service.jobs.store.sql.tables import artifacts
from service.scenes import world_cache as worlds
from service.scenes.store.records import scenes
from service.settings import Settings

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from starlette.testclient import TestClient

HALF_BOX = """<robot name="m"><link name="base"/><link name="a"><collision><geometry>
<box size="{size} {size} {size}"/></geometry></collision></link>
<joint name="j" type="prismatic"><parent link="base"/><child link="a"/><axis xyz="1 0 0"/>
<limit lower="-2" upper="{upper}" velocity="1" effort="1"/></joint></robot>"""
FACES = [(1, 2, 4), (1, 4, 3), (5, 7, 8), (5, 8, 6), (1, 5, 6), (1, 6, 2)]
FACES += [(3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5), (2, 6, 8), (2, 8, 4)]


def cube(half):
    sides = (-half, half)
    rows = [f"v {x} {y} {z}" for x in sides for y in sides for z in sides]
    return "\n".join([*rows, *(f"f {a} {b} {c}" for a, b, c in FACES)])


class Cell:
    """A robot and an obstacle in files, and servers of one data folder, one after the other."""

    def __init__(self, folder):
        self.robot, self.mesh = folder / "files/r.urdf", folder / "files/o.obj"
        self.settings = Settings(engine="inline", data_dir=folder / "state")
        self.robot.parent.mkdir()
        self.write()

    def write(self, *, size=0.1, upper=2.0, half=0.1):
        self.robot.write_text(HALF_BOX.format(size=size, upper=upper))
        self.mesh.write_text(cube(half))

    @property
    def document(self):
        shape = {"mesh": {"uri": str(self.mesh)}}
        return {
            "name": "cell",
            "robots": [{"name": "r", "model": str(self.robot)}],
            "objects": [{"name": "o", "shape": shape, "pose": {"position": [0, 0.4, 0]}}],
        }

    def server(self):
        """A client of a server."""
        return TestClient(create_app(self.settings))


@pytest.fixture
def cell(tmp_path):
    return Cell(tmp_path)


@pytest.fixture
def forgetful(monkeypatch):
    """No world stays in memory, as if every question were the first of a new process."""
    monkeypatch.setattr(worlds, "MAX_WORLDS", 0)


@pytest.fixture
def running(cell):
    with cell.server() as client:
        yield client


def post(client, cell):
    answer = client.post("/v1/scenes", json=cell.document)
    assert answer.status_code == 201, answer.text
    return answer.json()


def certified(client, scene, *, to=1.0, **more):
    motion = {"times": [0, 4], "positions": [[0], [to]], "velocities": [[0], [0]]}
    body = {"scene": scene["id"], "group": "r", "trajectory": motion, **more}
    answer = client.post("/v1/trajectories/certify", json=body)
    assert answer.status_code == 200, answer.text
    return answer.json()["certificate"]


def planned(client, scene, to=1.0):
    goal = {"type": "joint", "positions": [to]}
    request = {"scene": scene["id"], "group": "r", "goal": goal, "seed": 1}
    request |= {"start": [0.0], "search": {"allowed_planning_time": 30}}
    return client.post("/v1/plans?wait=40", json=request).json()


@pytest.mark.parametrize("change", [{"upper": 0.5}, {"size": 1.0}, {"half": 0.4}])
def test_a_scene_posted_again_is_what_the_files_are_now(cell, running, change):
    before = post(running, cell)
    first = certified(running, before)
    assert first["proven"]
    cell.write(**change)
    after = post(running, cell)
    assert after["digest"] != before["digest"]
    assert not certified(running, after)["proven"]
    assert certified(running, before) == first
    old, new = (planned(running, scene) for scene in (before, after))
    assert old["state"] == "succeeded"
    assert new["state"] == "failed"
    checked = {"group": "r", "configurations": [[0.0], [1.0]]}
    verdicts = [
        [
            verdict["valid"]
            for verdict in running.post(f"/v1/scenes/{scene['id']}/check", json=checked).json()[
                "results"
            ]
        ]
        for scene in (before, after)
    ]
    assert verdicts[0] == [True, True] != verdicts[1]
    cell.write()
    assert post(running, cell)["digest"] == before["digest"]


@pytest.mark.usefixtures("forgetful")
def test_plans_are_repeated_and_replayed_when_the_files_are_gone(cell):
    with cell.server() as client:
        scene = post(client, cell)
        plan = planned(client, scene)
        first = certified(client, scene)
    cell.write(size=1.0)
    with cell.server() as client:
        page = client.get(f"/v1/plans/{plan['id']}/replay.html")
        assert planned(client, scene)["result"]["digest"] == plan["result"]["digest"]
    shutil.rmtree(cell.robot.parent)
    with cell.server() as client:
        assert certified(client, scene) == first
        again = client.post("/v1/plans?wait=40", json=plan["request"]).json()
        assert again["result"] == plan["result"]
        assert client.get(f"/v1/plans/{plan['id']}/replay.html").content == page.content
        assert client.post("/v1/scenes", json=cell.document).status_code == 422


def test_an_edit_keeps_what_was_there_and_reads_what_is_new(cell, running):
    before = post(running, cell)
    cell.write(size=1.0, half=0.05)
    added = {**cell.document["objects"][0], "name": "late", "pose": {"position": [0, -0.4, 0]}}
    answer = running.patch(
        f"/v1/scenes/{before['id']}", json={"operations": [{"op": "add", "object": added}]}
    )
    assert answer.status_code == 200, answer.text
    after = answer.json()
    assert after["files"]["r"] == before["files"]["r"]
    assert after["files"]["o"] == before["files"]["o"] != after["files"]["late"]
    found = certified(running, before)
    assert found["proven"]
    # The object of old is 0.1 m to each side, the robot 0.05 m: 0.4 - 0.15.
    assert found["min_clearance"] == pytest.approx(0.25, abs=1e-3)
    cell.mesh.unlink()
    moved = {"operations": [{"op": "set_positions", "robot": "r", "positions": [0.5]}]}
    assert running.patch(f"/v1/scenes/{before['id']}", json=moved).status_code == 200


def test_a_scene_tells_its_files(cell, running):
    files = post(running, cell)["files"]
    assert set(files) == {"r", "o"}
    assert files["o"]["named"] == str(cell.mesh)
    assert list(files["r"]["sha256"]) == ["r.urdf"]
    for kept in files.values():
        for sha256 in kept["sha256"].values():
            assert (cell.settings.data_dir / "files/bytes" / sha256).is_file()


def encoded(written):
    return Encoded(encode(written["document"]))


@pytest.mark.usefixtures("forgetful")
@pytest.mark.parametrize("fault", ["edited", "without files", "of other files"])
def test_a_scene_that_is_not_what_was_accepted_is_refused(cell, fault):
    with cell.server() as client:
        scene = post(client, cell)
    engine = create_engine(cell.settings.url)
    with engine.connect() as connection:
        name = connection.execute(select(scenes.c.artifact)).scalar_one()
        written = json.loads(read_content(connection, name))
    if fault == "edited":
        written["document"]["objects"][0]["pose"]["position"] = [0, 5, 0]
    elif fault == "without files":
        written["files"] = None
    else:
        written["files"] = {}
        cell.write(half=0.01)
    with engine.begin() as connection:
        content = encode_in_parts({"files": written["files"], "document": encoded(written)})
        change = update(artifacts).where(artifacts.c.digest == name)
        connection.execute(change.values(content=content.encode()))
    shutil.rmtree(cell.settings.data_dir / "files/bytes")
    body = {"group": "r", "configurations": [[0.0]]}
    with cell.server() as client:
        answer = client.post(f"/v1/scenes/{scene['id']}/check", json=body)
        assert answer.status_code == 409
        assert answer.json()["code"] == "scene_not_kept"
        assert answer.json()["evidence"]["digest"] == scene["digest"]


@pytest.mark.usefixtures("forgetful")
def test_lost_copies_come_again_from_the_database(cell):
    with cell.server() as client:
        scene = post(client, cell)
        plan = planned(client, scene)
        first = certified(client, scene)
    for lost in ("files/folders", "files/bytes", "files"):
        shutil.rmtree(cell.settings.data_dir / lost)
        with cell.server() as client:
            assert certified(client, scene) == first
            assert client.get(f"/v1/plans/{plan['id']}/replay.html").status_code == 200
            again = client.post("/v1/plans?wait=40", json=plan["request"]).json()
            assert again["result"] == plan["result"]


@pytest.mark.usefixtures("forgetful")
def test_files_that_are_lost_altogether_are_said(cell):
    with cell.server() as client:
        scene = post(client, cell)
    shutil.rmtree(cell.settings.data_dir / "files")
    engine = create_engine(cell.settings.url)
    with engine.begin() as connection:
        connection.execute(delete(artifacts).where(artifacts.c.world_digest.is_(None)))
    with cell.server() as client:
        body = {"group": "r", "configurations": [[0.0]]}
        answer = client.post(f"/v1/scenes/{scene['id']}/check", json=body)
        assert answer.json()["code"] == "asset_not_found"
