"""ArtifactStore: the record of artifacts, in the database of jobs."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

from anyio import to_thread
from sqlalchemy import Connection, Engine, delete, select, update
from sqlalchemy.dialects import postgresql, sqlite

from service.jobs.artifacts import Artifact
from service.jobs.store.sql.database import set_durability
from service.jobs.store.sql.tables import artifacts, jobs

# Databases bound the number of parameters of a statement.
_AT_ONCE = 500


class ArtifactStore:
    """Artifacts in a database; each is stored once, and goes when nothing needs it any more."""

    def __init__(self, engine: Engine) -> None:
        """Keep them in `engine`."""
        self._engine = engine

    def put(self, connection: Connection, artifact: Artifact, world_digest: str) -> str:
        """Store an artifact in a transaction, and return its digest.

        Args:
            connection: In a transaction.
            artifact: What to store.
            world_digest: It stays as long as a job or a scene has this content.
        """
        self.add(connection, artifact.digest, artifact, world_digest)
        return artifact.digest

    def add(
        self, connection: Connection, digest: str, artifact: Artifact, world_digest: str | None
    ) -> None:
        """Store an artifact of a known digest; one that is stored already is marked as new.

        Args:
            connection: In a transaction.
            digest: Of the artifact.
            artifact: What to store.
            world_digest: As in `put`; None for a part of other artifacts, and stays with them.
        """
        made = postgresql.insert if connection.dialect.name == "postgresql" else sqlite.insert
        row = {
            "digest": digest,
            "content": artifact.content,
            "parts": list(artifact.parts),
            "world_digest": world_digest,
            "stored_at": _now(),
        }
        # Another server may store the same at this moment.
        connection.execute(made(artifacts).values(row).on_conflict_do_nothing())

    def refresh(self, connection: Connection, digests: Sequence[str]) -> set[str]:
        """Mark artifacts as new: they are in use again; return those that are not stored."""
        found: set[str] = set()
        for these in _portions(digests):
            is_one = artifacts.c.digest.in_(these)
            renewed = update(artifacts).where(is_one).values(stored_at=_now())
            found |= set(connection.execute(renewed.returning(artifacts.c.digest)).scalars().all())
        return set(digests) - found

    def keep(self, artifact: Artifact, world_digest: str) -> str:
        """Store an artifact, durably, and return its digest."""
        with self._engine.begin() as connection:
            set_durability(connection, is_durable=True)
            if self.refresh(connection, [artifact.digest]):
                self.put(connection, artifact, world_digest)
        return artifact.digest

    async def parts(self, digests: Sequence[str]) -> Mapping[str, tuple[str, ...]]:
        """Return which artifacts are needed with each of some, as far as they are stored."""
        return await to_thread.run_sync(self._parts, digests)

    async def contents(self, digests: Sequence[str]) -> Mapping[str, bytes]:
        """Return the bytes of artifacts, as far as they are stored."""
        return await to_thread.run_sync(self._contents, digests)

    def sweep(self, connection: Connection, is_needed: Sequence[str], before: datetime) -> int:
        """Delete what nothing needs, and return how many that are.

        Args:
            connection: In a transaction.
            is_needed: Contents (`world_digest`) that are needed besides those of jobs.
            before: What was stored later stays (UTC).
        """
        of_jobs = select(jobs.c.world_digest).where(jobs.c.world_digest.is_not(None)).distinct()
        needed = {*is_needed, *connection.execute(of_jobs).scalars().all()}
        rows = connection.execute(
            select(artifacts.c.digest, artifacts.c.world_digest, artifacts.c.parts, _STORED)
        ).all()
        is_old = {row.digest: row.stored_at < before.isoformat() for row in rows}
        whole = [row for row in rows if row.world_digest is not None]
        stays = [row for row in whole if row.world_digest in needed or not is_old[row.digest]]
        parts = {part for row in stays for part in row.parts}
        kept = parts | {row.digest for row in stays}
        gone = [digest for digest, old in is_old.items() if old and digest not in kept]
        # Not what another server has begun to use since the rows were read.
        is_still_old = artifacts.c.stored_at < before.isoformat()
        count = 0
        for these in _portions(gone):
            ended = delete(artifacts).where(artifacts.c.digest.in_(these), is_still_old)
            count += connection.execute(ended).rowcount
        return count

    def _parts(self, digests: Sequence[str]) -> dict[str, tuple[str, ...]]:
        query = select(artifacts.c.digest, artifacts.c.parts)
        with self._engine.connect() as connection:
            found = connection.execute(query.where(artifacts.c.digest.in_(digests))).all()
        return {row.digest: tuple(row.parts) for row in found}

    def _contents(self, digests: Sequence[str]) -> dict[str, bytes]:
        query = select(artifacts.c.digest, artifacts.c.content)
        with self._engine.connect() as connection:
            found = connection.execute(query.where(artifacts.c.digest.in_(digests))).all()
        return {row.digest: row.content for row in found}


_STORED = artifacts.c.stored_at


def read_content(connection: Connection, digest: str) -> bytes | None:
    """Return the bytes of an artifact; None if it is not stored."""
    return connection.execute(
        select(artifacts.c.content).where(artifacts.c.digest == digest)
    ).scalar()


def _portions(digests: Sequence[str]) -> list[Sequence[str]]:
    return [digests[i : i + _AT_ONCE] for i in range(0, len(digests), _AT_ONCE)]


def _now() -> str:
    return datetime.now(UTC).isoformat()
