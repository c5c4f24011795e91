"""Two bodies in a plane whose ways cross: each plan holds while the other body stands."""

CROSSING = {
    "name": "crossing",
    "robots": [
        {"name": "a", "model": "planar_l", "positions": [-0.4, 0.0, 0.0]},
        {"name": "b", "model": "planar_l", "positions": [0.0, -0.4, 0.0]},
        {"name": "c", "model": "planar_l", "positions": [0.4, -0.45, 0.0]},
    ],
}
# Where each goes: the first two through the same place, the third one on the spot, to the side.
GOALS = {"a": [0.4, 0.0, 0.0], "b": [0.0, 0.4, 0.0], "c": [0.4, -0.45, 0.4]}


def posted(client, document=CROSSING):
    answer = client.post("/v1/scenes", json=document)
    assert answer.status_code == 201, answer.text
    return answer.json()["id"]


def planned(client, scene, robot, goal=None, **fields):
    """The id of a plan of a robot to its goal."""
    request = {
        "scene": scene,
        "group": robot,
        "goal": {"type": "joint", "positions": goal or GOALS[robot]},
        "refine": {"method": "none"},
        "search": {"allowed_planning_time": 60.0},
        **fields,
    }
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert job["state"] == "succeeded", job["failure"]
    return job["id"]


def execute(client, wait=0, **fields):
    return client.post(f"/v1/executions?wait={wait}", json={"driver": "kinematic", **fields})


def ended(client, execution):
    """An execution once it has ended."""
    with client.stream("GET", f"/v1/executions/{execution}/events") as stream:
        for _ in stream.iter_lines():
            pass
    return client.get(f"/v1/executions/{execution}").json()


def status(client, execution):
    return client.get(f"/v1/executions/{execution}").json()["status"]


def begun(client, execution):
    """Wait until an execution moves."""
    while not (status(client, execution) or {}).get("time"):
        pass


def where(client, scene):
    """Where each robot is, by its live state."""
    robots = client.get(f"/v1/scenes/{scene}/state").json()["robots"]
    return {each["robot"]: each["positions"]["base_joint"] for each in robots}


def edited(client, scene, *operations):
    answer = client.patch(f"/v1/scenes/{scene}", json={"operations": list(operations)})
    assert answer.status_code == 200, answer.text
    return answer.json()


def box(name, position, size=0.1):
    shape = {"box": [size] * 3}
    return {"op": "add", "object": {"name": name, "shape": shape, "pose": {"position": position}}}
