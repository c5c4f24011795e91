"""SceneShelf: the scene store for coroutines."""

import asyncio
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from anyio import to_thread

from service.jobs.errors import DatabaseUnavailable
from service.scenes.latest import Latest
from service.scenes.records import LoadedScene, SceneBrief, SceneRecord
from service.scenes.store import SceneStore

if TYPE_CHECKING:
    from collections.abc import Awaitable

# How long a write waits for the writes of others [s].
_PATIENCE = 5.0


class SceneShelf:
    """Asks the store in a thread, because databases and disks make one wait.

    Attributes:
        latest: Revisions that need not be read.
        settle: What the latest revision goes through before it is given out: it returns the one
            that knows where executions left the robots, and whether nothing moves them now.
        forgotten: Called after a scene was deleted.
    """

    def __init__(self, store: SceneStore) -> None:
        """Ask `store`."""
        self._store = store
        self._writing = asyncio.Lock()
        self.latest = Latest()
        self.settle: Callable[[SceneRecord], Awaitable[tuple[SceneRecord, bool]]] | None = None
        self.forgotten: Callable[[], None] | None = None

    async def add(self, loaded: LoadedScene) -> SceneRecord:
        """Record a scene that a slot has loaded."""
        return await self._write(self._store.add, loaded)

    async def revise(self, base: SceneBrief, loaded: LoadedScene) -> SceneRecord:
        """Record the revision that follows `base`.

        Raises:
            UnknownResource: The scene is gone.
            RevisionConflict: `base` has a successor already.
        """
        with self.latest.changing(base.id):
            return await self._write(self._store.revise, base, loaded)

    async def get(self, identifier: str, revision: int | None = None) -> SceneRecord:
        """Return a revision of a scene, by default the latest, with its robots where they are.

        Raises:
            UnknownResource: There is none.
        """
        if revision is not None or self.settle is None:
            return await self.stored(identifier, revision)
        return self.latest.of(identifier) or await self.fresh(identifier)

    async def fresh(self, identifier: str) -> SceneRecord:
        """Return the latest revision as `get` does, but by a look at what is stored.

        Raises:
            UnknownResource: There is none.
        """
        look = self.latest.look()
        record = await self.stored(identifier)
        if self.settle is None:
            return record
        record, is_at_rest = await self.settle(record)
        if is_at_rest:
            self.latest.keep(record, look)
        return record

    async def stored(self, identifier: str, revision: int | None = None) -> SceneRecord:
        """Return a revision as it is stored, by default the latest.

        Raises:
            UnknownResource: There is none.
        """
        return await to_thread.run_sync(self._store.get, identifier, revision)

    async def page(self, limit: int, before: int | None) -> list[SceneBrief]:
        """Return scenes older than the serial `before`, newest first."""
        return await to_thread.run_sync(self._store.page, limit, before)

    async def delete(self, identifier: str) -> None:
        """Forget a scene.

        Raises:
            UnknownResource: There is none.
        """
        with self.latest.changing(identifier):
            await self._write(self._store.delete, identifier)
        if self.forgotten is not None:
            self.forgotten()

    async def file(self, record: SceneRecord) -> Path:
        """Return the file of a scene's document."""
        path = self._store.path(record.digest)
        if path.is_file():  # quicker than a thread
            return path
        return await to_thread.run_sync(self._store.file, record)

    async def _write[**P, T](self, work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Write in a thread, one after the other: those that wait leave the threads to readers.

        Raises:
            DatabaseUnavailable: Others wait for the database, and it does nothing.
        """
        try:
            async with asyncio.timeout(_PATIENCE):
                await self._writing.acquire()
        except TimeoutError:
            raise DatabaseUnavailable.of(_PATIENCE) from None
        try:
            return await to_thread.run_sync(partial(work, *args, **kwargs))
        finally:
            self._writing.release()
