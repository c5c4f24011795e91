"""A server and its workers that are killed while a gripper takes hold: all that is told agrees."""

import pytest
import yaml

from tests.profiles import only_campaign
from tests.service.executions.can_in_gripper import GRIPPER, TEXT
from tests.service.executions.killed_at import INSTANTS
from tests.service.servers import server, until
from tests.service.successor import successor

MODULE = "tests.service.executions.killed_at"
HELD = {"unrecorded": False, "unattached": True, "attached": True}
CASES = [
    instant
    if instant == "attached"
    else pytest.param(instant, marks=only_campaign("a server starts twice: 15 s"))
    for instant in INSTANTS
]


def grasp_until_killed(folder, instant, driver="kinematic", **grasp):
    """The ids of the scene and of the execution that a server began, and was killed in."""
    with server(folder, module=MODULE, KILLED_AT=instant) as killed:
        document = yaml.safe_load(TEXT)
        next(each for each in document["objects"] if each["name"] == "can")["mass"] = 0.3
        goal = {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "pick"}]}
        asked = {"group": "arm", "goal": goal, "ik": {"max_configurations": 1}, "seed": 1}
        scene = killed.ask("POST", "/v1/scenes", document)["id"]
        found = killed.ask("POST", f"/v1/scenes/{scene}/ik", asked)["configurations"][0]
        place = {"op": "set_positions", "robot": "arm", "positions": found["positions"]}
        killed.ask("PATCH", f"/v1/scenes/{scene}", {"operations": [place]})
        gripper = {"scene": scene, "group": GRIPPER, "grasp": {"object": "can", **grasp}}
        gripper |= {"force": 60.0} if grasp else {}
        body = {"gripper": gripper, "driver": driver, "speed": 5}
        execution = killed.ask("POST", "/v1/executions", body)["id"]
        assert killed.process.wait(120) < 0
    return scene, execution


@pytest.mark.parametrize("instant", CASES)
def test_an_object_is_held_exactly_if_the_execution_has_succeeded(tmp_path, instant):
    agrees_after(tmp_path, instant, HELD[instant])


@only_campaign("a server starts twice, and simulates: 20 s")
@pytest.mark.parametrize("instant", INSTANTS)
def test_so_is_one_that_is_held_by_contact(tmp_path, instant):
    status = agrees_after(tmp_path, instant, HELD[instant], driver="simulated", by="contact")
    assert bool(status["held"]) or not HELD[instant]


def agrees_after(folder, instant, is_held, **grasp):
    """The last status of an execution, after what a server says that follows was looked at."""
    scene, identifier = grasp_until_killed(folder, instant, **grasp)
    with successor(folder) as restarted:

        def shown():
            return restarted.ask("GET", f"/v1/executions/{identifier}")

        until(lambda: shown()["finished_at"])
        execution = shown()
        live = restarted.ask("GET", f"/v1/scenes/{scene}/state")
        assert execution["state"] == ("succeeded" if is_held else "aborted")
        assert (execution["failure"] is None) == is_held
        if not is_held:
            assert execution["failure"]["code"] == "server_restarted"
        assert [each["object"] for each in live["attached"]] == (["can"] if is_held else [])
        assert live["grippers"][0]["holds"] == (["can"] if is_held else [])
        assert live["revision"] == (3 if is_held else 2)
        (robot,) = live["robots"]
        assert (robot["status"], robot["execution"]) == ("at_rest", None)
        status = execution["status"]
        if status is not None:
            assert robot["positions"]["left_finger_joint"] == status["positions"][0]
        # The robot is free again.
        release = {"release": "can"} if is_held else {}
        gripper = {"scene": scene, "group": GRIPPER, "width": 0.05, **release}
        if is_held:
            body = {"gripper": gripper, "driver": "kinematic", "speed": 5}
            opened = restarted.ask("POST", "/v1/executions?wait=60", body)
            assert opened["state"] == "succeeded", opened["failure"]
        return status or {"held": []}
