"""SceneShelf: the scene store for coroutines."""

import asyncio
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from anyio import to_thread

from service.jobs.errors import DatabaseUnavailable
from service.scenes.records import LoadedScene, SceneBrief, SceneRecord
from service.scenes.store import SceneStore

if TYPE_CHECKING:
    from collections.abc import Awaitable

# How long a write waits for the writes of others [s].
_PATIENCE = 5.0


class SceneShelf:
    """Asks the store in a thread, because databases and disks make one wait.

    Attributes:
        settle: What the latest revision goes through before it is given out: it returns the one
            that knows where executions left the robots.
        forgotten: Called after a scene was deleted.
    """

    def __init__(self, store: SceneStore) -> None:
        """Ask `store`."""
        self._store = store
        self._writing = asyncio.Lock()
        self.settle: Callable[[SceneRecord], Awaitable[SceneRecord]] | None = None
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
        return await self._write(self._store.revise, base, loaded)

    async def get(self, identifier: str, revision: int | None = None) -> SceneRecord:
        """Return a revision of a scene, by default the latest, with its robots where they are.

        Raises:
            UnknownResource: There is none.
        """
        record = await self.stored(identifier, revision)
        if revision is not None or self.settle is None:
            return record
        return await self.settle(record)

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
        await self._write(self._store.delete, identifier)
        if self.forgotten is not None:
            self.forgotten()

    async def file(self, record: SceneRecord) -> Path:
        """Return the file of a scene's document."""
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
