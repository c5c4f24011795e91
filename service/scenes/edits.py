"""The next revision of a scene."""

from itertools import count

from service.errors import RevisionConflict
from service.jobs.service import JobService
from service.scenes.etags import check_match
from service.scenes.models.edits import SceneEdit
from service.scenes.store.records import SceneRecord
from service.scenes.store.scene_store import SceneStore
from service.scenes.tasks import EDIT_SCENE, LoadedScene, RequestWork

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
        InputError: An operation cannot be done, or what comes of it does not load.
    """
    rounds = count(1)
    while True:
        base = check_match(await scenes.get(identifier), if_match)
        if request.revision not in {None, base.revision}:
            wanted = await scenes.get(identifier, request.revision)
            raise RevisionConflict.of(identifier, wanted.revision, base.revision)
        loaded = await load_edited(base, request, scenes, jobs)
        try:
            return await scenes.revise(base, loaded)
        except RevisionConflict:
            if request.revision is not None or next(rounds) == _MAX_ROUNDS:
                raise


async def load_edited(
    record: SceneRecord, request: SceneEdit, scenes: SceneStore, jobs: JobService
) -> LoadedScene:
    """Return what comes of operations on a revision, without a record of it.

    Raises:
        UnknownName: An operation names what the scene does not have.
        InputError: An operation cannot be done, or what comes of it does not load.
    """
    work = RequestWork[SceneEdit].about(scenes.work(record), request)
    return await jobs.call_loading(EDIT_SCENE, work, size=len(request.operations))
