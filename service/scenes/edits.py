"""The next revision of a scene."""

from collections.abc import Mapping
from itertools import count
from typing import Any

from service.errors import RevisionConflict, RobotBusy
from service.jobs.service import JobService
from service.scenes.etags import check_match
from service.scenes.models.edits import (
    AttachOperation,
    DetachOperation,
    SceneEdit,
    SceneOperation,
    SetPositionsOperation,
)
from service.scenes.store.records import SceneRecord
from service.scenes.store.scene_store import SceneStore
from service.scenes.tasks import EDIT_SCENE, RequestWork

# Somebody who edits a scene faster than it can be loaded, again and again, is told so.
_MAX_ROUNDS = 10


async def apply_edits(
    identifier: str,
    request: SceneEdit,
    if_match: str | None,
    scenes: SceneStore,
    jobs: JobService,
    *,
    execution: str | None = None,
) -> SceneRecord:
    """Carry out operations and record what comes of them.

    Without a `revision` they are done to the latest; if another edit is quicker, they are done
    again to what that one left, so neither is lost.

    Args:
        identifier: Of the scene.
        request: The operations.
        if_match: The header `If-Match`, if there is one.
        scenes: Has the scene.
        jobs: Has it loaded.
        execution: On whose behalf this is, whose robots they may be about; None for a client.

    Raises:
        UnknownResource: There is no such scene or revision.
        RevisionConflict: The request names a revision that is not the latest.
        RevisionMismatch: The header `If-Match` names none that is the latest.
        UnknownName: An operation names what the scene does not have.
        RobotBusy: An operation places a robot that moves, or what it holds.
        InputError: An operation cannot be done, or what comes of it does not load.
    """
    rounds = count(1)
    while True:
        base = check_match(await scenes.get(identifier), if_match)
        if request.revision not in {None, base.revision}:
            wanted = await scenes.get(identifier, request.revision)
            raise RevisionConflict.of(identifier, wanted.revision, base.revision)
        require_idle(base, request, execution)
        work = RequestWork[SceneEdit].about(scenes.work(base), request)
        loaded = await jobs.call_loading(EDIT_SCENE, work, size=len(request.operations))
        try:
            record = await scenes.revise(base, loaded, request.placed_robots)
            return await scenes.with_live_state(record)
        except RevisionConflict:
            if request.revision is not None or next(rounds) == _MAX_ROUNDS:
                raise


def require_idle(record: SceneRecord, request: SceneEdit, execution: str | None = None) -> None:
    """Go on only if operations touch no robot that moves, or is about to.

    Args:
        record: The scene.
        request: The operations.
        execution: Whose robots they may touch; None for none.

    Raises:
        RobotBusy: One places it, or what it holds.
    """
    free = {None, execution}
    busy = {state.robot: state for state in record.live.values() if state.execution not in free}
    if not busy:
        return
    for operation in request.operations:
        robot = _robot_of(record, operation)
        if robot in busy:
            moving = busy[robot].execution
            message = (
                f"execution {moving} moves {robot}, so {operation.op} is not possible; wait for "
                "its end, or cancel it"
            )
            raise RobotBusy(message, {"execution": moving, "group": robot})


def _robot_of(record: SceneRecord, operation: SceneOperation) -> str | None:
    """Return the robot that an operation places, or whose load it changes; None for none."""
    match operation:
        case SetPositionsOperation():
            return operation.robot
        case AttachOperation():
            return _root(record.document, operation.frame)
        case DetachOperation():
            return _root(record.document, operation.object)
        case _:
            return None


def _root(document: Mapping[str, Any], frame: str) -> str:
    """Return the robot that a frame hangs on, or the name of what else it hangs on."""
    objects = {
        thing["name"]: (thing.get("attached") or {}).get("frame") for thing in document["objects"]
    }
    parents = {each["name"]: each["parent"] for each in document["frames"]} | objects
    for _ in range(len(parents) + 1):
        parent = parents.get(frame)
        if parent is None:
            break
        frame = parent
    return frame.partition("::")[0]
