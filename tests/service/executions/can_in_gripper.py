"""The scene `ur5e_pickup` as tests of grippers ask for it over HTTP: where the can can be held."""

import yaml

import planning

GRIPPER = "arm::gripper"
TEXT = (planning.bundled_folder("scenes") / "ur5e_pickup.scene.yaml").read_text()


def positions_at_can(client):
    """Where the joints of the arm are with the can between the fingers."""
    scene = posted(client, yaml.safe_load(TEXT))
    goal = {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "pick"}]}
    body = {"group": "arm", "goal": goal, "ik": {"max_configurations": 1}, "seed": 1}
    found = client.post(f"/v1/scenes/{scene}/ik", json=body).json()
    return found["configurations"][0]["positions"]


def posted(client, document):
    """The id of a scene that is made of a document."""
    answer = client.post("/v1/scenes", json=document)
    assert answer.status_code == 201, answer.text
    return answer.json()["id"]
