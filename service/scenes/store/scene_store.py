"""SceneStore: scenes survive the server."""

import asyncio
import secrets
from collections.abc import Awaitable, Callable, Collection, Generator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from anyio import to_thread
from sqlalchemy import Connection, Engine
from sqlalchemy.exc import IntegrityError

from service.errors import RevisionConflict, UnknownResource
from service.jobs.errors import DatabaseUnavailable
from service.jobs.job import IdempotencyKey
from service.jobs.store.artifact_store import ArtifactStore
from service.jobs.store.sql.database import set_durability
from service.jobs.store.sql.notifications import tell
from service.jobs.store.sql.schema import bring_up_to_date
from service.scenes.live import Motion
from service.scenes.models.verdicts import ExecutionVerdict
from service.scenes.store import live_rows, rows
from service.scenes.store.document_artifact import artifact_of, part_of
from service.scenes.store.former_files import adopt_files
from service.scenes.store.record_cache import Latest, RecentScenes
from service.scenes.store.records import SceneBrief, SceneRecord
from service.scenes.tasks import Library, LoadedScene, SceneWork, StoredScene

# How long a write waits for the writes of others [s].
_PATIENCE = 5.0


class SceneStore:
    """Scenes in the database; their documents are artifacts, as are the files they were made from.

    Artifacts outlive their scene, because plans that were made in it can still be replayed.
    Databases and disks make one wait, so threads ask them.

    Attributes:
        library: From which workers load robots.
        latest: Revisions that need not be read.
        moving: Returns the executions that move something in a scene, or wait to.
        verdicts: Returns what an edit means for the executions in a scene, given what came of it.
        on_delete: Called after a scene was deleted.
    """

    def __init__(self, engine: Engine, folder: Path, library: Library) -> None:
        """Keep records in `engine`; call `open` before use.

        Args:
            engine: Of the database.
            folder: Of this host, where workers leave the files that scenes are made from.
            library: From which workers load robots.
        """
        self.library = library
        self._engine = engine
        self._artifacts = ArtifactStore(engine)
        self._folder = folder
        self._writing = asyncio.Lock()
        self._recent = RecentScenes()
        self.latest = Latest(is_shared=engine.dialect.name == "postgresql")
        self.moving: Callable[[str], Awaitable[Sequence[Motion]]] = _nothing_moves
        self.verdicts: Callable[[SceneRecord], Awaitable[Sequence[ExecutionVerdict]]] = _no_verdict
        self.on_delete: Callable[[], None] | None = None

    async def open(self) -> None:
        """Create what is missing, and bring the database to the newest revision."""
        await to_thread.run_sync(self._open)

    async def add(self, loaded: LoadedScene, key: IdempotencyKey | None = None) -> SceneRecord:
        """Record a new scene, or return the one that a key names by now.

        Raises:
            IdempotencyConflict: The key was used for another request.
        """
        try:
            return await self._write(self._add, loaded, key)
        except IntegrityError:
            known = None if key is None else await self.find_by_key(key)
            if known is None:
                raise
            return known

    async def find_by_key(self, key: IdempotencyKey) -> SceneRecord | None:
        """Return the scene that an idempotency key names, as it is now; None if there is none.

        Raises:
            IdempotencyConflict: The key was used for another request.
        """
        known = await to_thread.run_sync(self._id_of_key, key)
        return None if known is None else await self.get(known)

    async def revise(
        self, base: SceneRecord, loaded: LoadedScene, placed: Collection[str] = ()
    ) -> SceneRecord:
        """Record the revision that follows `base`, and return it as it is described.

        Args:
            base: The latest revision, as it is.
            loaded: What follows.
            placed: Robots that were set by hand.

        Raises:
            UnknownResource: The scene is gone.
            RevisionConflict: `base` has a successor already.
        """
        with self.latest.changing(base.id):
            return await self._write(self._revise, base, loaded, placed)

    async def get(self, identifier: str, revision: int | None = None) -> SceneRecord:
        """Return a revision of a scene, by default the latest, with its robots where they are.

        Raises:
            UnknownResource: There is none.
        """
        if revision is not None:
            return await self.stored(identifier, revision)
        return self.latest.of(identifier) or await self.fresh(identifier)

    async def fresh(self, identifier: str) -> SceneRecord:
        """Return the latest revision as `get` does, but by a look at what is stored.

        Raises:
            UnknownResource: There is none.
        """
        look = self.latest.look()
        # First: what ends from now on is in the rows that are read after it.
        motions = await self.moving(identifier)
        record = await self.at(identifier, motions)
        if not motions:
            self.latest.keep(record, look)
        return record

    async def at(self, identifier: str, motions: Sequence[Motion]) -> SceneRecord:
        """Return the latest revision with its robots where they are.

        Args:
            identifier: Of the scene.
            motions: What was in it a moment ago: what has ended since is known to have.

        Raises:
            UnknownResource: There is none.
        """
        return await to_thread.run_sync(self._read_live, identifier, motions)

    async def with_live_state(self, record: SceneRecord) -> SceneRecord:
        """Return a revision that is the latest with its robots where they are."""
        motions = await self.moving(record.id)
        return await to_thread.run_sync(self._live, record, motions)

    async def stored(self, identifier: str, revision: int | None = None) -> SceneRecord:
        """Return a revision as it is stored, by default the latest.

        Raises:
            UnknownResource: There is none.
        """
        return await to_thread.run_sync(self._read, identifier, revision)

    async def page(
        self, limit: int, before: int | None = None, name: str | None = None
    ) -> tuple[list[SceneBrief], int | None]:
        """Return scenes older than the serial `before`, newest first; of one name, if it is given.

        Also the `before` of the page that follows; None if this is the last one.
        """
        found = await to_thread.run_sync(self._page, limit + 1, before, name)
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

    def work(self, record: SceneRecord) -> SceneWork:
        """Return what a task about a scene is given."""
        positions = {robot: dict(joints) for robot, joints in record.moved.items()}
        scene = StoredScene(digest=record.digest, document=record.artifact, positions=positions)
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
        with self._durable() as connection:
            adopt_files(connection, self._artifacts, self._folder)

    def _id_of_key(self, key: IdempotencyKey) -> str | None:
        with self._engine.connect() as connection:
            return rows.find_by_key(connection, key)

    def _add(self, loaded: LoadedScene, key: IdempotencyKey | None) -> SceneRecord:
        with self._durable() as connection:
            artifact = self._keep_artifact(connection, loaded)
            identifier = f"scn_{secrets.token_hex(8)}"
            record = rows.insert_revision(connection, identifier, 1, loaded, artifact)
            if key is not None:
                rows.write_key(connection, identifier, key)
        self._recent.put(record)
        return record

    def _revise(
        self, base: SceneRecord, loaded: LoadedScene, placed: Collection[str]
    ) -> SceneRecord:
        # The writes of a server are one after the other, those of several wait for the lock.
        with self._durable() as connection:
            rows.lock(connection, base.id)
            artifact = self._keep_artifact(connection, loaded)
            latest = rows.latest_revision(connection, base.id)
            if latest is None:
                raise UnknownResource.of("scene", base.id)
            if latest != base.revision:
                raise RevisionConflict.of(base.id, base.revision, latest)
            loaded, unchecked_in = self._sharing(base, loaded)
            row = (base.id, latest + 1, loaded, artifact, unchecked_in)
            record = rows.insert_revision(connection, *row)
            made = record.revision, record.created_at
            live_rows.write_placed(connection, base.id, placed, base.live, made)
            tell(connection, base.id)
        self._recent.put(record)
        return record

    def _read_live(self, identifier: str, motions: Sequence[Motion]) -> SceneRecord:
        return self._live(self._read(identifier, None), motions)

    def _live(self, record: SceneRecord, motions: Sequence[Motion]) -> SceneRecord:
        with self._engine.connect() as connection:
            return record.at(live_rows.read_states(connection, record.id), motions)

    def _read(self, identifier: str, revision: int | None) -> SceneRecord:
        with self._engine.connect() as connection:
            brief = rows.read_brief(connection, identifier, revision)
            known = self._recent.get(identifier, brief.revision)
            record = known or rows.read_record(connection, brief)
        self._recent.put(record)
        return record

    def _page(self, limit: int, before: int | None, name: str | None) -> list[SceneBrief]:
        with self._engine.connect() as connection:
            return rows.read_page(connection, limit, before, name)

    def _delete(self, identifier: str, revision: int | None) -> None:
        with self._durable() as connection:
            rows.lock(connection, identifier)
            latest = rows.latest_revision(connection, identifier)
            if latest is not None and revision not in {None, latest}:
                raise RevisionConflict.of(identifier, revision or 0, latest)
            rows.delete_rows(connection, identifier)
            live_rows.delete_states(connection, identifier)
            tell(connection, identifier)

    def _sharing(self, base: SceneBrief, loaded: LoadedScene) -> tuple[LoadedScene, int | None]:
        """Return what follows a revision, and which one's row has its unchecked pairs already.

        What an edit moves mostly does not change them, and of many objects they are half of it all.
        """
        before = self._recent.get(base.id, base.revision)
        if before is None or before.loaded.unchecked != loaded.unchecked:
            return loaded, None
        held = before.revision if before.unchecked_in is None else before.unchecked_in
        return loaded.model_copy(update={"unchecked": before.loaded.unchecked}), held

    def _keep_artifact(self, connection: Connection, loaded: LoadedScene) -> str:
        """Store the document and its files, as far as they are not stored, and return the digest.

        Raises:
            OSError: A file that the scene was made from cannot be read.
        """
        artifact = artifact_of(loaded)
        digest = artifact.digest
        missing = self._artifacts.refresh(connection, [digest, *artifact.parts])
        for part in missing - {digest}:
            self._artifacts.add(connection, part, part_of(self._folder, part), None)
        if digest in missing:
            self._artifacts.add(connection, digest, artifact, loaded.digest)
        return digest

    @contextmanager
    def _durable(self) -> Generator[Connection]:
        """Write what survives a power cut: connections are shared with what need not."""
        with self._engine.begin() as connection:
            set_durability(connection, is_durable=True)
            yield connection


async def _nothing_moves(_: str) -> Sequence[Motion]:
    return ()


async def _no_verdict(_: SceneRecord) -> Sequence[ExecutionVerdict]:
    return ()
