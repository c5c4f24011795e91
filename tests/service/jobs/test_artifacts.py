"""Each host gets what it lacks of artifacts, and what nothing needs any more goes."""

import asyncio
import os
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import event, insert, select, update

from service.jobs.artifacts import Artifact, ArtifactCopies
from service.jobs.host_folder import artifact_path
from service.jobs.job import JobSpec
from service.jobs.store.artifact_store import ArtifactStore
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from service.jobs.store.sql.tables import artifacts
from service.jobs.task import Task, TaskModel, artifacts_of

PART, OTHER = Artifact(b"part"), Artifact(b"another part")
WHOLE = Artifact(b"whole", (PART.digest, OTHER.digest))
ALL = {artifact.digest: artifact for artifact in (PART, OTHER, WHOLE)}


class Source:
    """Artifacts in memory; counts what it gives away."""

    def __init__(self):
        self.given = []

    async def parts(self, digests):
        return {digest: ALL[digest].parts for digest in digests if digest in ALL}

    async def contents(self, digests):
        self.given += digests
        return {digest: ALL[digest].content for digest in digests if digest in ALL}


@pytest.fixture
def source():
    return Source()


@pytest.fixture
def copies(tmp_path, source):
    return ArtifactCopies(tmp_path, source)


def test_a_host_gets_an_artifact_with_its_parts_once(copies, source, tmp_path):
    for _ in range(2):
        asyncio.run(copies.bring([WHOLE.digest]))
        for digest, artifact in ALL.items():
            assert artifact_path(tmp_path, digest).read_bytes() == artifact.content
    assert sorted(source.given) == sorted(ALL)


def test_what_is_lost_comes_again_alone(copies, source, tmp_path):
    asyncio.run(copies.bring([WHOLE.digest]))
    artifact_path(tmp_path, OTHER.digest).unlink()
    source.given.clear()
    asyncio.run(copies.bring([WHOLE.digest]))
    assert source.given == [OTHER.digest]


def test_what_is_nowhere_is_left_to_the_task(copies, tmp_path):
    asyncio.run(copies.bring(["0" * 64, PART.digest]))
    assert artifact_path(tmp_path, PART.digest).is_file()
    assert not artifact_path(tmp_path, "0" * 64).exists()


def test_a_copy_that_is_in_use_is_marked_so(tmp_path, source):
    asyncio.run(ArtifactCopies(tmp_path, source).bring([WHOLE.digest]))
    path = artifact_path(tmp_path, PART.digest)
    os.utime(path, (0, 0))
    later = ArtifactCopies(tmp_path, source)
    asyncio.run(later.bring([WHOLE.digest]))
    assert path.stat().st_mtime > 0
    os.utime(path, (0, 0))
    asyncio.run(later.bring([WHOLE.digest]))  # a moment later
    assert path.stat().st_mtime == 0


def test_what_is_remembered_has_a_bound(copies, monkeypatch):
    monkeypatch.setattr("service.jobs.artifacts._MAX_REMEMBERED", 2)
    for _ in range(2):
        for digest in (*ALL, *("0" * 63 + each for each in "abcdef")):
            asyncio.run(copies.bring([digest]))
    assert max(len(copies._parts), len(copies._marked_at)) <= 3 + len(WHOLE.parts)


def test_a_folder_that_cannot_be_written_is_said(tmp_path, source):
    (tmp_path / "files").write_text("no folder")
    with pytest.raises(OSError, match="files"):
        asyncio.run(ArtifactCopies(tmp_path, source).bring([WHOLE.digest]))


class InnerModel(TaskModel):
    document: str


class ReadingModel(TaskModel):
    artifact_members = ("scene.document", "regions")

    scene: InnerModel
    regions: str | None = None


READING = Task("test_artifacts.reading", ReadingModel, TaskModel)


@pytest.mark.parametrize(
    ("payload", "named"),
    [
        ({"scene": {"document": "d"}, "regions": "r"}, ["d", "r"]),
        ({"scene": {"document": "d"}, "regions": None}, ["d"]),
        ({"scene": "odd"}, []),
        ({}, []),
    ],
)
def test_a_task_says_which_artifacts_it_reads(payload, named):
    assert artifacts_of(READING.name, payload) == named
    assert artifacts_of("unknown", payload) == []


@pytest.fixture
def engine(tmp_path):
    made = open_engine(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    JobStore(made).open()
    yield made
    made.dispose()


def stored(engine):
    with engine.connect() as connection:
        return set(connection.execute(select(artifacts.c.digest)).scalars())


def test_what_is_kept_twice_is_stored_once_and_is_new_again(engine):
    store = ArtifactStore(engine)
    digest = store.keep(PART, "world")
    with engine.begin() as connection:
        connection.execute(update(artifacts).values(stored_at="2000"))
    assert store.keep(PART, "world") == digest == PART.digest
    with engine.connect() as connection:
        (row,) = connection.execute(select(artifacts)).all()
    assert row.stored_at > "2000"
    assert row.content == PART.content


NAMES = "abcdef"
ROWS = st.dictionaries(
    st.sampled_from(NAMES),
    st.tuples(
        st.booleans(), st.sampled_from([None, "u", "v", "w"]), st.sets(st.sampled_from(NAMES))
    ),
)


@given(
    rows=ROWS, of_scenes=st.sets(st.sampled_from("uvw")), of_jobs=st.sets(st.sampled_from("uvw"))
)
def test_what_is_needed_or_new_stays_and_the_rest_goes(rows, of_scenes, of_jobs):
    """A row is (whether it is old, the content that it is of, its parts)."""
    engine, now = open_engine("sqlite://"), datetime.now(UTC)
    jobs = JobStore(engine)
    jobs.open()
    for world in of_jobs:
        jobs.insert(JobSpec("plan", "m:f", {}, world_digest=world))
    with engine.begin() as connection:
        for name, (is_old, world, parts) in rows.items():
            at = now - timedelta(hours=2 if is_old else 0)
            row = {"digest": name, "content": b"", "parts": sorted(parts), "world_digest": world}
            connection.execute(insert(artifacts).values(**row, stored_at=at.isoformat()))
        before = now - timedelta(hours=1)
        gone = ArtifactStore(engine).sweep(connection, sorted(of_scenes), before)
    needed = {None: False} | {world: world in of_scenes | of_jobs for world in "uvw"}
    whole = {
        name
        for name, (is_old, world, _) in rows.items()
        if world is not None and (needed[world] or not is_old)
    }
    of_whole = {part for name in whole for part in rows[name][2]}
    stays = {
        name for name, (is_old, _, _) in rows.items() if not is_old or name in whole | of_whole
    }
    assert stored(engine) == stays
    assert gone == len(rows) - len(stays)
    engine.dispose()


def test_what_is_used_again_while_the_rest_goes_stays(engine):
    """Another server may post a scene between the look at the rows and their end."""
    store, other = ArtifactStore(engine), open_engine(engine.url.render_as_string())
    old = [store.keep(artifact, "gone") for artifact in (PART, OTHER)]
    with engine.begin() as connection:
        connection.execute(update(artifacts).values(stored_at="2000"))

    def use(_, __, statement, *___):
        if statement.startswith("DELETE FROM artifacts"):
            ArtifactStore(other).keep(PART, "gone")

    event.listen(engine, "before_cursor_execute", use)
    with engine.begin() as connection:
        store.sweep(connection, [], datetime.now(UTC) - timedelta(hours=1))
    other.dispose()
    assert stored(engine) == {old[0]}
