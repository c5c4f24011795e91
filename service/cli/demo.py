"""wayproof demo: a UR5e fetches a can, from nothing to executed, certified motions."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, cast

import typer
from rich.table import Table

from service.cli.open_studio import open_studio
from service.cli.options import AsJson, Seed, ServerUrl, above_zero
from service.cli.output import console, error_console, print_json
from service.cli.runs import executed, finished
from service.cli.session import post, scene_text, session
from wayproof_client.models import Execution, Plan

_SCENE = "ur5e_pickup"
_ARM, _GRIPPER = "arm", "arm::gripper"
# Of a finger [m]: 0.2 mm from the can, whose radius is 0.02, and all the way.
_CLOSED, _OPEN = 0.0202, 0.025
# How far the can is lifted [m]: the box in the way is 0.26 m high.
_HEIGHT = 0.28


@dataclass(frozen=True)
class _Motion:
    """Something that moves: planned, proven and executed."""

    title: str
    group: str
    goal: dict[str, Any]


@dataclass(frozen=True)
class _Edit:
    """Something that the scene is told."""

    title: str
    operation: dict[str, Any]


def _pose(frame: str, height: float = 0.0) -> dict[str, Any]:
    """Return a pose that looks down as a frame does, whose z axis points down."""
    return {"position": [0, 0, -height], "frame": frame}


def _up(way: float) -> dict[str, Any]:
    """Return the goal to go straight up by some metres."""
    return {"type": "line", "displacement": {"vector": [0, 0, way]}}


# The last 10 cm in a straight line, from above.
_GRASP = {"type": "pose", "poses": [_pose("pick")], "approach": [0, 0, -0.1]}

_STORY = (
    _Motion("approach", _ARM, _GRASP),
    _Motion("close", _GRIPPER, {"type": "joint", "positions": [_CLOSED]}),
    _Edit("attach", {"op": "attach", "object": "can", "frame": "arm::tcp"}),
    _Motion("lift", _ARM, _up(_HEIGHT)),
    _Motion("carry", _ARM, {"type": "pose", "poses": [_pose("place", _HEIGHT)]}),
    _Motion("place", _ARM, {"type": "line", "pose": _pose("place")}),
    _Edit("detach", {"op": "detach", "object": "can"}),
    _Motion("open", _GRIPPER, {"type": "joint", "positions": [_OPEN]}),
    _Motion("retreat", _ARM, _up(0.1)),
    _Motion("go home", _ARM, {"type": "configuration", "name": "home"}),
)


def demo(
    *,
    out: Annotated[Path, typer.Option(help="Folder for the replay.")] = Path("out"),
    speed: Annotated[
        float, typer.Option(help="Pace of the execution; 1 is real time.", callback=above_zero)
    ] = 1.0,
    seed: Seed = 1,
    open_page: Annotated[
        bool, typer.Option("--open", help="Then open the studio of the server, until Ctrl-C.")
    ] = False,
    server: ServerUrl = None,
    as_json: AsJson = False,
) -> None:
    """Fetch a can over HTTP: plan, prove and execute every motion, and write a replay of all."""
    with session(server) as client:
        scene = post(client, scene_text(_SCENE))
        shown = error_console if as_json else console
        shown.print(
            f"scene {scene.name}: {len(scene.bodies)} bodies, {scene.num_pairs} pairs kept apart, "
            f"groups {', '.join(group.name for group in scene.groups)}"
        )
        table = _table()
        jobs: list[dict[str, str]] = []
        for step in _STORY:
            if isinstance(step, _Edit):
                edited = client.edit_scene(scene.id, {"operations": [cast("Any", step.operation)]})
                shown.print(f"{step.title:<16} revision {edited.revision} of the scene")
                table.add_row(step.title, *[""] * 4, f"revision {edited.revision}")
                continue
            job = finished(client, f"plan {step.title}", _request(scene.id, step, seed))
            execution = executed(client, step.title, job.id, speed)
            table.add_row(step.title, *_facts(job, execution))
            jobs.append({"title": step.title, "plan": job.id, "execution": execution.id})
        shown.print(table)
        file = out / f"{_SCENE}.html"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(client.get_scene_replay(scene.id), encoding="utf-8")
        shown.print(f"replay of what was executed: {file}", soft_wrap=True)
        if as_json:
            print_json({"scene": scene.id, "steps": jobs, "replay": str(file)})
        if open_page:
            shown.print(f"the scene of the demo is '{scene.name} · {scene.id}' there")
            open_studio(client.url, stays=server is None)


def _request(scene: str, motion: _Motion, seed: int) -> dict[str, Any]:
    """Return the request for a plan from wherever the robot is."""
    return {
        "scene": scene,
        "group": motion.group,
        "goal": motion.goal,
        "search": {"allowed_planning_time": 20.0},
        "seed": seed,
    }


def _table() -> Table:
    title = "What was planned, proven (with its min clearance) and executed (within which error)"
    table = Table(title=title, title_justify="left")
    table.add_column("")
    for head in ("plan, ms", "motion, s", "proven", "clearance, mm", "executed"):
        table.add_column(head, justify="right")
    return table


def _facts(job: Plan, execution: Execution) -> list[str]:
    result, status = job.result, execution.status
    if result is None or status is None or not (result.certificate and result.trajectory):
        return []
    proof = result.certificate
    return [
        f"{1000 * job.timings['total']:.0f}",
        f"{result.trajectory.duration:.2f}",
        "yes" if proof.proven else "NO",
        "nothing to hit" if proof.min_clearance is None else f"{1000 * proof.min_clearance:.1f}",
        f"{status.max_tracking_error:.0e} {'rad' if execution.group == _ARM else 'm'}",
    ]
