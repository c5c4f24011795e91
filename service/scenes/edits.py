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
) -> SceneRecord:
    """Carry out operations and record what comes of them.

    Without a `revision` they are done to the latest; if another edit is quicker, they are done
    again to what that one left, so neither is lost.

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
        require_idle(base, request)
        work = RequestWork[SceneEdit].about(scenes.work(base), request)
        loaded = await jobs.call_loading(EDIT_SCENE, work, size=len(request.operations))
        try:
            record = await scenes.revise(base, loaded, request.placed_robots)
            return await scenes.with_live_state(record)
        except RevisionConflict:
            if request.revision is not None or next(rounds) == _MAX_ROUNDS:
                raise


def require_idle(record: SceneRecord, request: SceneEdit) -> None:
    """Go on only if operations touch no robot that moves, or is about to.

    Raises:
        RobotBusy: One places it, or what it holds.
    """
    busy = {state.robot: state for state in record.live.values() if state.execution is not None}
    if not busy:
        return
    for operation in request.operations:
        robot = _robot_of(record, operation)
        if robot in busy:
            execution = busy[robot].execution
            message = (
                f"execution {execution} moves {robot}, so {operation.op} is not possible; wait for "
                "its end, or cancel it"
            )
            raise RobotBusy(message, {"execution": execution, "group": robot})


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
