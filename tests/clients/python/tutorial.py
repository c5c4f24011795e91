"""The steps of docs/tutorial/first-motion.md, by a client of `openapi-python-client`.

Called with the server's address and the scene's file; prints what it found as JSON. Type-checked
in strict mode against the generated package: nothing of it is cast.
"""

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import httpx_sse
import yaml
from wayproof_openapi import AuthenticatedClient
from wayproof_openapi.api.executions import create_execution, get_execution
from wayproof_openapi.api.models import get_model, list_models
from wayproof_openapi.api.plans import create_plan, get_replay, get_trajectory
from wayproof_openapi.api.queries import check_configurations, solve_inverse_kinematics
from wayproof_openapi.api.scenes import create_scene, get_scene_replay
from wayproof_openapi.models import (
    Certificate,
    CheckRequest,
    CheckResponse,
    DriverName,
    Execution,
    ExecutionRequest,
    FinishedData,
    IkRequest,
    IkResponse,
    Model,
    ModelList,
    NotFoundProblem,
    Plan,
    PlanRequest,
    Pose,
    PoseGoal,
    Scene,
    SceneDocument,
    StageData,
    Trajectory,
    UnknownNameProblem,
)


def main(url: str, scene_file: str) -> dict[str, object]:
    """Carry out the tutorial; every answer is of the type that the document promises."""
    # A server that asks for no keys does not look at it.
    key = os.environ.get("WAYPROOF_API_KEY", "none")
    client = AuthenticatedClient(base_url=url, token=key)
    scene = load(client, Path(scene_file).read_text())
    arm = scene.groups[0]

    verdicts = check_configurations.sync(
        scene.id, client=client, body=CheckRequest(configurations=[arm.positions], group=arm.name)
    )
    assert isinstance(verdicts, CheckResponse), verdicts
    goal = PoseGoal(type_="pose", poses=[Pose(position=[0, 0, 0], frame="pick")], frame="arm::tcp")
    solved = solve_inverse_kinematics.sync(
        scene.id, client=client, body=IkRequest(goal=goal, group="arm")
    )
    assert isinstance(solved, IkResponse), solved
    nearest = solved.configurations[0]

    request = PlanRequest(scene=scene.id, group="arm", goal=goal, seed=7)
    plan = create_plan.sync(client=client, body=request, wait=60)
    assert isinstance(plan, Plan), plan
    assert plan.result is not None, plan.failure
    certificate = plan.result.certificate  # absent only where `include` leaves it out
    assert isinstance(certificate, Certificate)
    samples = get_trajectory.sync(plan.id, client=client, period=0.01)
    assert isinstance(samples, Trajectory), samples
    page = get_replay.sync(plan.id, client=client)
    assert isinstance(page, str), page
    stages = [
        StageData.from_dict(json.loads(event.data)).stage
        for event in events(client, f"/v1/plans/{plan.id}/events")
        if event.event == "stage"
    ]

    moved = execute(client, plan)
    executed = get_scene_replay.sync(scene.id, client=client)
    assert isinstance(executed, str), executed
    return {
        "models": models(client),
        "valid": verdicts.results[0].valid,
        "num_configurations": len(solved.configurations),
        "clearance": nearest.clearance,
        "proven": certificate.proven,
        "duration": samples.duration,
        "last_time": samples.times[-1],
        "stages": stages,
        "execution": moved.state.value,
        "replays": [len(page), len(executed)],
        "refusals": refusals(client, request),
    }


def load(client: AuthenticatedClient, text: str) -> Scene:
    """Post a scene that is written in YAML; the generated client sends JSON."""
    scene = create_scene.sync(client=client, body=SceneDocument.from_dict(yaml.safe_load(text)))
    assert isinstance(scene, Scene), scene
    return scene


def models(client: AuthenticatedClient) -> dict[str, list[str]]:
    """Return the joints of every robot that scenes may name."""
    listed = list_models.sync(client=client)
    assert isinstance(listed, ModelList), listed
    found: dict[str, list[str]] = {}
    for name in listed.items:
        model = get_model.sync(name, client=client)
        assert isinstance(model, Model), model
        found[name] = [joint.name for joint in model.groups[0].joints]
    return found


def execute(client: AuthenticatedClient, plan: Plan) -> Execution:
    """Carry a plan out, watch it until it ends, and return how it ended."""
    driver = DriverName.SIMULATED
    request = ExecutionRequest(plan=plan.id, driver=driver, speed=10.0, title="to the can")
    begun = create_execution.sync(client=client, body=request)
    assert isinstance(begun, Execution), begun
    told = list(events(client, f"/v1/executions/{begun.id}/events"))
    end = FinishedData.from_dict(json.loads(told[-1].data))
    ended = get_execution.sync(begun.id, client=client)
    assert isinstance(ended, Execution), ended
    assert ended.state.value == end.state.value == "succeeded", ended.failure
    return ended


def refusals(client: AuthenticatedClient, request: PlanRequest) -> list[str]:
    """Return what is said of a name that is wrong, and of a scene that is not there."""
    request.group = "amr"
    misspelt = create_plan.sync(client=client, body=request)
    assert isinstance(misspelt, UnknownNameProblem), misspelt
    assert misspelt.code == "unknown_name"
    missing = check_configurations.sync(
        "scn_0", client=client, body=CheckRequest(configurations=[[0.0]], group="arm")
    )
    assert isinstance(missing, NotFoundProblem), missing
    return [misspelt.detail, missing.detail]


def events(client: AuthenticatedClient, path: str) -> Iterator[httpx_sse.ServerSentEvent]:
    """Yield the events of a stream: the generated client has their types, and httpx-sse reads."""
    with httpx_sse.connect_sse(client.get_httpx_client(), "GET", path) as source:
        yield from source.iter_sse()


if __name__ == "__main__":
    json.dump(main(*sys.argv[1:]), sys.stdout)
