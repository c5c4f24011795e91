"""wayproof demo: a UR5e fetches a can, from nothing to an executed, certified motion."""

from pathlib import Path
from typing import Annotated, Any

import typer

from service.cli.goal import goal_of, group_of
from service.cli.options import MAX_SEED, above_zero
from service.cli.plan import finished, write
from service.cli.screen import console, follow, show_execution, show_failure, show_plans, unit_of
from service.cli.session import scene_text, session
from service.client.client import Client
from service.schemas.execution import Execution, ExecutionState
from service.schemas.job import Job

_SCENE = "ur5e_pickup"
_WAYPOINTS = ("pick", "place")


def demo(
    *,
    out: Annotated[Path, typer.Option(help="Folder for the replays.")] = Path("out"),
    speed: Annotated[
        float, typer.Option(help="Pace of the execution; 1 is real time.", callback=above_zero)
    ] = 1.0,
    seed: Annotated[int, typer.Option(help="Of all randomness.", min=0, max=MAX_SEED)] = 1,
    server: Annotated[str | None, typer.Option(help="URL of a running server.")] = None,
) -> None:
    """Plan home -> pick -> place in a bundled scene, execute both, and write the replays."""
    with session(server) as client:
        scene = client.add_scene(*scene_text(_SCENE))
        group = group_of(scene, None)
        console.print(
            f"scene {scene.name}: {len(scene.bodies)} bodies, {scene.num_pairs} pairs kept apart, "
            f"group {group.name} with {len(group.joints)} joints"
        )
        plans: dict[str, Job] = {}
        start: list[float] | None = None
        for target in _WAYPOINTS:
            request: dict[str, Any] = {
                "scene": scene.id,
                "group": group.name,
                "start": start,
                "goal": goal_of(scene, group, target),
                "search": {"allowed_planning_time": 20.0},
                "seed": seed,
            }
            job = finished(client, f"plan {target}", request)
            plans[f"to {target}"] = job
            start = job.result.goal_configuration if job.result else None
        executions = {name: executed(client, name, job, speed) for name, job in plans.items()}
        show_plans(plans, unit_of(group))
        for name, execution in executions.items():
            show_execution(name, execution, unit_of(group))
        for i, (name, job) in enumerate(plans.items(), 1):
            file = out / f"{_SCENE}-{i}-{name.replace(' ', '-')}.html"
            write(client, job, file)
            console.print(f"replay: {file}", soft_wrap=True)


def executed(client: Client, name: str, job: Job, speed: float) -> Execution:
    """Carry out a plan, show its progress, and return how it ended.

    Raises:
        typer.Exit: With 1, after a message, if it did not succeed.
    """
    execution = client.execute(job.id, speed)
    follow(f"execute {name.removeprefix('to ')}", client.execution_events(execution.id))
    execution = client.execution(execution.id)
    if execution.state is not ExecutionState.SUCCEEDED:
        show_failure(f"the execution {name}", execution.failure)
        raise typer.Exit(1)
    return execution
