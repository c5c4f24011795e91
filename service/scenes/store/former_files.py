"""adopt_files(): what version 0.1 kept in files of the data folder goes into the database."""

from pathlib import Path

from sqlalchemy import Connection, select

from service.jobs.artifacts import Artifact
from service.jobs.host_folder import artifact_path
from service.jobs.store.artifact_store import ArtifactStore
from service.jobs.store.sql.tables import artifacts, jobs
from service.scenes.store.document_artifact import files_of


def adopt_files(connection: Connection, store: ArtifactStore, folder: Path) -> None:
    """Store documents of scenes that are gone, and files of scenes, that only the disk has.

    Jobs name such a document by the content of its scene, as its file is named. Where nothing was
    left behind this is one look at the database.

    Args:
        connection: In a transaction.
        store: Of artifacts.
        folder: The data folder, with `scenes` and `files`.
    """
    for name in _without_document(connection):
        file = folder / "scenes" / f"{name}.json"
        if file.is_file():
            content = file.read_bytes()
            kept = files_of(content).values()
            parts = {part for each in kept for part in each["sha256"].values()}
            store.add(connection, name, Artifact(content, tuple(sorted(parts))), name)
    for digest in _without_content(connection):
        file = artifact_path(folder, digest)
        if file.is_file():
            store.add(connection, digest, Artifact(file.read_bytes()), None)


def _without_document(connection: Connection) -> list[str]:
    of_artifacts = select(artifacts.c.world_digest).where(artifacts.c.world_digest.is_not(None))
    query = select(jobs.c.world_digest).where(jobs.c.world_digest.not_in(of_artifacts)).distinct()
    return list(connection.execute(query).scalars())


def _without_content(connection: Connection) -> list[str]:
    """Return the parts that artifacts name and that are not stored."""
    found = connection.execute(select(artifacts.c.digest, artifacts.c.parts)).all()
    named = {part for row in found for part in row.parts}
    return sorted(named - {row.digest for row in found})
