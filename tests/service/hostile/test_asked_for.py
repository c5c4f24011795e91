"""What a scene cannot do is refused with the reason, and tells nothing that it should not."""

import json
import warnings

import pytest

import planning
from planning.errors import ProblemInvalid
from planning.retime.limits.request_limits import path_limits
from service.app import create_app
from service.jobs.worker.run_task import run_task
from service.settings import Settings
from tests.service.hostile.files import urdf
from tests.service.hostile.test_bodies import tells_of_the_server
from tests.service.jobs import fake_tasks

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from starlette.testclient import TestClient

STILL = '<robot name="s"><link name="base"><collision><geometry><box size="1 1 1"/></geometry>'
STILL += "</collision></link></robot>"
ENDLESS = urdf(limit='<limit lower="-1" upper="1" velocity="1" effort="0"/>')


@pytest.fixture
def posted(client, tmp_path):
    """The id of a scene with a robot `r` that has no limit on effort, and a still one."""
    for name, text in (("r", ENDLESS), ("still", STILL)):
        (tmp_path / f"{name}.urdf").write_text(text)
    robots = [{"name": name, "model": str(tmp_path / f"{name}.urdf")} for name in ("r", "still")]
    robots[1]["base"] = {"position": [0, 9, 0]}
    answer = client.post("/v1/scenes", json={"name": "s", "robots": robots})
    assert answer.status_code == 201, answer.text
    return answer.json()["id"]


MOTION = {"times": [0, 4], "positions": [[0], [0.5]], "velocities": [[0], [0]]}
GOAL = {"type": "joint", "positions": [0.5]}


@pytest.mark.parametrize(
    ("path", "body"),
    [
        ("plans", {"goal": GOAL, "retime": {"effort": True}}),
        ("trajectories/retime", {"waypoints": [[0], [0.5]], "retime": {"effort": True}}),
        ("trajectories/certify", {"trajectory": MOTION, "effort": True}),
    ],
)
def test_efforts_that_nothing_limits_cannot_be_kept(client, posted, path, body):
    answer = client.post(f"/v1/{path}", json={"scene": posted, "group": "r", **body})
    assert (answer.status_code, answer.json()["code"]) == (422, "problem_invalid"), answer.text
    assert "no joint of 'r' has a force or torque limit" in answer.json()["detail"]


def test_the_engine_refuses_them_too(urdf_world):
    world = urdf_world(ENDLESS)
    with pytest.raises(ProblemInvalid, match="no joint of 'r' has a force or torque limit"):
        path_limits(world, world.group("r"), planning.RetimeOptions(effort=True))


def test_a_robot_that_cannot_move_is_an_obstacle_and_no_group(client, posted):
    body = {"scene": posted, "group": "still", "goal": GOAL}
    answer = client.post("/v1/plans", json=body)
    assert (answer.status_code, answer.json()["code"]) == (422, "model_invalid"), answer.text
    assert "no joint of it moves" in answer.json()["detail"]
    assert answer.json()["evidence"]["robot"] == "still"
    checked = {"group": "r", "configurations": [[0.0]]}
    assert client.post(f"/v1/scenes/{posted}/check", json=checked).json()["results"][0]["valid"]


@pytest.fixture
def public(tmp_path):
    """A server beyond loopback, with a folder of robots of which one is broken."""
    broken = tmp_path / "roots/broken"
    broken.mkdir(parents=True)
    card = "name: b\nfile: b.urdf\nbase: base\ndefault_group: g\ngroups: {g: {joints: [j]}}\n"
    (broken / "robot.yaml").write_text(card)
    (broken / "b.urdf").write_text(urdf(shape='<mesh filename="../../gone.obj"/>'))
    (tmp_path / "bad").mkdir()
    settings = Settings(
        engine="inline",
        host="0.0.0.0",
        auth="proxy",
        data_dir=tmp_path / "data",
        model_roots=[tmp_path / "roots"],
    )
    with TestClient(create_app(settings)) as client:
        yield client


def told(client, document):
    answer = client.post("/v1/scenes", json=document)
    assert answer.status_code == 422
    return {**answer.json(), "title": ""}


@pytest.mark.parametrize("kind", ["robot", "mesh", "edit"])
def test_beyond_loopback_files_that_are_there_answer_like_those_that_are_not(
    public, kind, tmp_path
):
    there, missing = tmp_path / "there.obj", tmp_path / "gone.obj"
    there.write_text("v 0 0 0\n")
    scene = public.post("/v1/scenes", json={"robots": [{"name": "a", "model": "planar_l"}]})

    def answer(path):
        if kind == "robot":
            return told(public, {"robots": [{"name": "a", "model": str(path)}]})
        thing = {"name": "o", "shape": {"mesh": {"uri": str(path)}}}
        if kind == "mesh":
            return told(
                public, {"robots": [{"name": "a", "model": "planar_l"}], "objects": [thing]}
            )
        operations = {"operations": [{"op": "add", "object": thing}]}
        return public.patch(f"/v1/scenes/{scene.json()['id']}", json=operations).json()

    def plain(path):
        return json.dumps(answer(path)).replace(str(path), "PATH")

    assert plain(there) == plain(missing) != ""
    assert answer("/etc/passwd")["code"] == "asset_not_found"


def test_a_robot_of_the_server_that_is_broken_tells_no_folder(public, tmp_path):
    for answer in (
        public.post("/v1/scenes", json={"robots": [{"name": "a", "model": "broken"}]}),
        public.get("/v1/models/broken"),
    ):
        assert answer.status_code == 422
        assert "gone.obj" in answer.text
        assert str(tmp_path) not in answer.text
        assert not tells_of_the_server(answer.text)


def test_a_fault_of_ours_tells_no_traceback(caplog):
    assert fake_tasks.blunder  # its import has the task carried out
    end = run_task("fake.blunder", "{}", None)
    assert not tells_of_the_server(end.text)
    evidence = json.loads(end.text)["evidence"]
    assert set(evidence) == {"exception", "reference"}
    assert evidence["reference"] in caplog.text
    assert "Traceback" in caplog.text
