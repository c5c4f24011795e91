"""SceneStore: scenes survive the server."""

import asyncio
import secrets
from collections.abc import Awaitable, Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from anyio import to_thread
from sqlalchemy import Connection, Engine
from sqlalchemy.exc import DBAPIError

from planning.parallel.atomic_files import write_durably
from service.errors import RevisionConflict, UnknownResource
from service.jobs.errors import DatabaseUnavailable
from service.jobs.json_text import encode
from service.jobs.store.database import set_durability
from service.jobs.store.schema import bring_up_to_date
from service.scenes import rows
from service.scenes.record_cache import Latest, RecentScenes
from service.scenes.records import SceneBrief, SceneRecord
from service.scenes.tasks import Library, LoadedScene, SceneWork, StoredScene

# How long a write waits for the writes of others [s].
_PATIENCE = 5.0


class SceneStore:
    """Scenes in the database; their documents also as files, which is where workers read them.

    The files are a copy, named by content: written before they are needed, and again if lost. They
    outlive their scene, because plans that were made in it can still be replayed. Databases and
    disks make one wait, so threads ask them.

    Attributes:
        library: From which workers load robots.
        latest: Revisions that need not be read.
        settle: What the latest revision goes through before it is given out: it returns the one
            that knows where executions left the robots, and whether nothing moves them now.
        on_delete: Called after a scene was deleted.
    """

    def __init__(self, engine: Engine, folder: Path, library: Library) -> None:
        """Keep records in `engine` and files in `folder`; call `open` before use.

        Args:
            engine: Of the database.
            folder: Of the documents' files.
            library: From which workers load robots.
        """
        self.library = library
        self._engine = engine
        self._folder = folder.resolve()
        self._writing = asyncio.Lock()
        self._recent = RecentScenes()
        self._beside = ThreadPoolExecutor(1, "scene-files")
        self.latest = Latest(is_shared=engine.dialect.name == "postgresql")
        self.settle: Callable[[SceneRecord], Awaitable[tuple[SceneRecord, bool]]] | None = None
        self.on_delete: Callable[[], None] | None = None

    async def open(self) -> None:
        """Create what is missing, and bring the database to the newest revision."""
        await to_thread.run_sync(self._open)

    async def add(self, loaded: LoadedScene) -> SceneRecord:
        """Record a new scene."""
        return await self._write(self._add, loaded)

    async def revise(self, base: SceneBrief, loaded: LoadedScene) -> SceneRecord:
        """Record the revision that follows `base`.

        Raises:
            UnknownResource: The scene is gone.
            RevisionConflict: `base` has a successor already.
        """
        with self.latest.changing(base.id):
            return await self._write(self._revise, base, loaded)

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
        return await to_thread.run_sync(self._read, identifier, revision)

    async def page(
        self, limit: int, before: int | None = None
    ) -> tuple[list[SceneBrief], int | None]:
        """Return scenes older than the serial `before`, newest first.

        Also the `before` of the page that follows; None if this is the last one.
        """
        found = await to_thread.run_sync(self._page, limit + 1, before)
        return found[:limit], found[limit - 1].serial if len(found) > limit else None

    async def delete(self, identifier: str, revision: int | None = None) -> None:
        """Forget a scene; plans that were made in it stay.

        Raises:
            UnknownResource: There is none.
            RevisionConflict: It is not at that revision, if one is given.
        """
        with self.latest.changing(identifier):
            await self._write(self._delete, identifier, revision)
        if self.on_delete is not None:
            self.on_delete()

    async def file(self, record: SceneRecord) -> Path:
        """Return the file of a scene's document, written again if it was lost."""
        path = self._path(record.digest)
        if not path.is_file():  # to look is quicker than a thread
            await to_thread.run_sync(self._write_file, record.loaded)
        return path

    async def work(self, record: SceneRecord) -> SceneWork:
        """Return what a task about a scene is given."""
        scene = StoredScene(digest=record.digest, document=str(await self.file(record)))
        return SceneWork(library=self.library, scene=scene)

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

    def _open(self) -> None:
        bring_up_to_date(self._engine)
        self._folder.mkdir(parents=True, exist_ok=True)

    def _add(self, loaded: LoadedScene) -> SceneRecord:
        with self._recording(loaded) as connection:
            identifier = f"scn_{secrets.token_hex(8)}"
            record = rows.insert_revision(connection, identifier, 1, loaded)
        self._recent.put(record)
        return record

    def _revise(self, base: SceneBrief, loaded: LoadedScene) -> SceneRecord:
        # The writes of a server are one after the other, those of several wait for the lock.
        with self._recording(loaded) as connection:
            rows.lock(connection, base.id)
            latest = rows.latest_revision(connection, base.id)
            if latest is None:
                raise UnknownResource.of("scene", base.id)
            if latest != base.revision:
                raise RevisionConflict.of(base.id, base.revision, latest)
            loaded, unchecked_in = self._sharing(base, loaded)
            record = rows.insert_revision(connection, base.id, latest + 1, loaded, unchecked_in)
        self._recent.put(record)
        return record

    def _read(self, identifier: str, revision: int | None) -> SceneRecord:
        with self._engine.connect() as connection:
            brief = rows.read_brief(connection, identifier, revision)
            known = self._recent.get(identifier, brief.revision)
            record = known or rows.read_record(connection, brief)
        self._recent.put(record)
        return record

    def _page(self, limit: int, before: int | None) -> list[SceneBrief]:
        with self._engine.connect() as connection:
            return rows.read_page(connection, limit, before)

    def _delete(self, identifier: str, revision: int | None) -> None:
        with self._durable() as connection:
            rows.lock(connection, identifier)
            latest = rows.latest_revision(connection, identifier)
            if latest is not None and revision not in {None, latest}:
                raise RevisionConflict.of(identifier, revision or 0, latest)
            rows.delete_rows(connection, identifier)

    def _sharing(self, base: SceneBrief, loaded: LoadedScene) -> tuple[LoadedScene, int | None]:
        """Return what follows a revision, and which one's row has its unchecked pairs already.

        What an edit moves mostly does not change them, and of many objects they are half of it all.
        """
        before = self._recent.get(base.id, base.revision)
        if before is None or before.loaded.unchecked != loaded.unchecked:
            return loaded, None
        held = before.revision if before.unchecked_in is None else before.unchecked_in
        return loaded.model_copy(update={"unchecked": before.loaded.unchecked}), held

    @contextmanager
    def _recording(self, loaded: LoadedScene) -> Generator[Connection]:
        """Write a row while another thread writes the file, and commit once it has.

        Raises:
            OSError: The file cannot be written; there is no row then.
        """
        file = self._beside.submit(self._write_file, loaded)
        try:
            with self._durable() as connection:
                yield connection
                file.result()
        except DBAPIError:
            file.result()  # a full disk refuses both, and says so better
            raise

    @contextmanager
    def _durable(self) -> Generator[Connection]:
        """Write what survives a power cut: connections are shared with what need not."""
        with self._engine.begin() as connection:
            set_durability(connection, is_durable=True)
            yield connection

    def _path(self, digest: str) -> Path:
        """Return where the file of a document is, or would be."""
        return self._folder / f"{digest}.json"

    def _write_file(self, loaded: LoadedScene) -> None:
        """Write the document and what its files are, whole or not at all."""
        written = f'{{"document":{loaded.document.text}'
        files = loaded.summary.files
        if files is not None:
            plain = {name: kept.model_dump() for name, kept in files.items()}
            written += f',"files":{encode(plain)}'
        write_durably(self._path(loaded.digest), f"{written}}}".encode())
