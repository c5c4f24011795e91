"""What the studio offers to ask instead of a request that failed: it must do."""

from pathlib import Path

import pytest

from service.studio.plans.failure_view import place_of
from service.studio.plans.relaxations import relaxations_of
from tests.profiles import only_campaign

PICKUP = (Path(__file__).parents[3] / "scenes" / "ur5e_pickup.scene.yaml").read_bytes()
THROUGH_TABLE = {"type": "joint", "positions": [[0, 0.5, 0, 0, 0, 0]]}
IN_TABLE = {
    "type": "pose",
    "poses": [{"position": [0.5, 0.2, -0.02], "quaternion": [0, 1, 0, 0]}],
}
FAR = {"type": "pose", "poses": [{"position": [1.5, 0.2, 0.1], "quaternion": [0, 1, 0, 0]}]}


def plan(client, request):
    return client.post("/v1/plans?wait=60", json=request).json()


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("goal", "num"),
    [
        pytest.param(THROUGH_TABLE, 2, id="joint"),
        pytest.param(IN_TABLE, 2, id="pose", marks=only_campaign("four searches of goals")),
        pytest.param(FAR, 2, id="far", marks=only_campaign("four searches of goals")),
    ],
)
def test_each_thing_to_ask_instead_gets_further(client, goal, num):
    """No relaxed request fails as the first one did; the nearest configuration is planned to."""
    scene = client.post("/v1/scenes", content=PICKUP, headers={"content-type": "application/yaml"})
    name, objects = scene.json()["id"], ["table", "box", "can"]
    search = {"allowed_planning_time": 60.0}
    request = {"scene": name, "group": "arm", "goal": goal, "search": search}
    failed = plan(client, request)["failure"]
    found = relaxations_of(failed, request, objects)
    assert len(found) >= num
    assert found[0].text.startswith("Go ")
    for relaxation in found:
        if relaxation.operations:
            body = {"operations": relaxation.operations}
            assert client.patch(f"/v1/scenes/{name}", json=body).status_code == 200
        job = plan(client, relaxation.request)
        failure = job["failure"] or {"code": ""}
        assert failure["code"] != failed["code"], (relaxation.text, failure)


def test_nothing_is_taken_away_that_is_not_the_browsers_own():
    failure = {"code": "goal_in_collision", "evidence": {"relaxation": {"remove": ["box"]}}}
    request = {"goal": THROUGH_TABLE, "search": {"allowed_planning_time": 1.0}}
    assert relaxations_of(failure, request, ()) == []
    assert [found.text for found in relaxations_of(failure, request, ["box"])] == ["Take box away"]


def test_a_search_that_was_too_short_is_asked_for_longer():
    failure = {"code": "no_path_found", "evidence": None}
    request = {"goal": FAR, "search": {"allowed_planning_time": 5.0}}
    (longer,) = relaxations_of(failure, request, ())
    assert longer.request["search"]["allowed_planning_time"] == 20.0


def test_a_motion_that_was_refused_has_its_place():
    evidence = {"check": "clearance", "pair": ["arm::hand", "box"], "time": 0.4, "value": -0.01}
    time, pair = place_of(evidence)
    assert (time, pair["bodies"], pair["depth"]) == (0.4, ["arm::hand", "box"], 0.01)
    assert place_of({}) is None
