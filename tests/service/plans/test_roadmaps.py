"""Roadmaps over HTTP: built once for a scene as a group sees it, kept on disk, told of."""

import pytest

from service.plans.worker import roadmaps_in
from tests.service.plans.test_search_options import MAZE

FEW = {"states": 300, "neighbours": 8}


@pytest.fixture
def posted(client):
    """A scene of its own, and a function that plans in it."""
    scene = client.post("/v1/scenes", json=MAZE).json()["id"]

    def plan(roadmap, status=200, via=client, **fields):
        request = {
            "scene": scene,
            "group": "body",
            "goal": {"type": "configuration", "name": "beyond"},
            "refine": {"method": "none"},
            "search": {"allowed_planning_time": 60.0, "roadmap": roadmap},
            **fields,
        }
        answer = via.post("/v1/plans?wait=60", json=request)
        assert answer.status_code == status, answer.text
        return answer.json()

    return scene, plan


def test_a_roadmap_is_built_once_and_changes_no_byte(posted, settings):
    _, plan = posted
    first, second = plan(FEW), plan(FEW)
    assert first["result"] == second["result"]
    told = first["result"]["stages"]["search"]
    assert told["planner"] == "roadmap"
    assert told["roadmap"]["used"]
    assert told["roadmap"]["num_states"] == 300
    assert "roadmap_build" in first["timings"]
    assert "roadmap" in second["timings"]
    assert "roadmap_build" not in second["timings"]
    # As in a worker that has just been started: what is in memory is gone, what is on disk is not.
    assert list((settings.data_dir / "roadmaps").glob("*.json"))
    roadmaps_in.cache_clear()
    third = plan(FEW)
    assert third["result"] == first["result"]
    assert "roadmap_build" not in third["timings"]


def test_an_edit_of_what_is_around_makes_another_roadmap(client, posted):
    scene, plan = posted
    before = plan(FEW)["result"]["stages"]["search"]["roadmap"]["digest"]
    moved = {"op": "move", "object": "wall", "pose": {"position": [0.02, -0.25, 0]}}
    answer = client.patch(f"/v1/scenes/{scene}", json={"operations": [moved]})
    assert answer.status_code == 200, answer.text
    after = plan(FEW)
    assert "roadmap_build" in after["timings"]
    assert after["result"]["stages"]["search"]["roadmap"]["digest"] != before
    old = plan(FEW, revision=1)
    assert old["result"]["stages"]["search"]["roadmap"]["digest"] == before
    assert "roadmap_build" not in old["timings"]


def test_without_a_roadmap_nothing_is_said_of_one(posted):
    _, plan = posted
    done = plan(None)
    assert done["result"]["stages"]["search"]["roadmap"] is None
    assert "roadmap" not in done["timings"]


@pytest.mark.parametrize(
    "roadmap",
    [{"states": 0}, {"states": 20_001}, {"neighbours": 0}, {"seed": -1}, {"size": 3}, True],
)
def test_nonsense_is_refused(posted, roadmap):
    _, plan = posted
    assert plan(roadmap, status=422)["code"] == "request_invalid"


def test_a_roadmap_under_path_constraints_keeps_them_and_is_kept(posted):
    _, plan = posted
    limits = [{"type": "joint_limits", "limits": {"body::base_joint.x": [-0.42, 0.42]}}]
    free, first, second = plan(FEW), *(plan(FEW, path_constraints=limits) for _ in range(2))
    assert first["state"] == "succeeded", first["failure"]
    assert first["result"] == second["result"]
    told = [job["result"]["stages"]["search"]["roadmap"] for job in (free, first)]
    assert told[0]["digest"] != told[1]["digest"]
    assert told[1]["used"]
    assert max(abs(row[0]) for row in first["result"]["path"]) <= 0.42
    assert "roadmap_build" in first["timings"]
    assert "roadmap_build" not in second["timings"]


@pytest.mark.parametrize("kind", ["line", "path"])
def test_lines_are_refused_together_with_a_roadmap(posted, kind):
    _, plan = posted
    target = {"position": [0.0, 0.05, 0.0]}
    goal = {"line": {"pose": target}, "path": {"poses": [target]}}[kind]
    problem = plan(FEW, status=422, goal={"type": kind, **goal})
    assert "search.roadmap" in str(problem)
