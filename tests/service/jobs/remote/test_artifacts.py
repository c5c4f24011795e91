"""A run on a host finds what it reads, which the host copies from the dispatcher's database."""

import asyncio
import json
from contextlib import asynccontextmanager
from dataclasses import replace

import pytest

from service.jobs.artifacts import Artifact, ArtifactCopies
from service.jobs.host_folder import artifact_path
from service.jobs.hosts.plan import HostPlan, own_version
from service.jobs.hosts.remote_host import RemoteHost
from service.jobs.outcome import Crashed, Returned, Terminated
from service.jobs.worker.main import Terms
from tests.service.jobs.conftest import GUARD, TASKS, WARM_UP
from tests.service.jobs.remote.machines import REMOTE, machines
from tests.service.jobs.worker.test_process_worker import run_of


class Stored:
    """A database of artifacts, which may be away for a while, and counts what it is asked."""

    def __init__(self, *artifacts, faults=0):
        self.artifacts = {each.digest: each for each in artifacts}
        self.faults = faults
        self.asked = []

    async def parts(self, digests):
        self.asked.append(("parts", *digests))
        if self.faults:
            self.faults -= 1
            raise ConnectionError("the database is away")
        return {each: self.artifacts[each].parts for each in digests if each in self.artifacts}

    async def contents(self, digests):
        self.asked.append(("contents", *digests))
        return {each: self.artifacts[each].content for each in digests if each in self.artifacts}


MESH = Artifact(bytes(range(256)) * 20_000)  # 5 MB, some pieces
TEXTURE = Artifact(b"x" * 10)
EMPTY = Artifact(b"")
SCENE = Artifact(b"{}", (MESH.digest, TEXTURE.digest, EMPTY.digest))
ALL = [each.digest for each in (SCENE, MESH, TEXTURE, EMPTY)]


@pytest.fixture(params=REMOTE)
def kind(request):
    """Where hosts are."""
    return request.param


@asynccontextmanager
async def working(kind, source, folder):
    """A worker on a host that has nothing yet."""
    plan = HostPlan((TASKS,), None, (Terms(),), own_version(), str(folder))
    copies = ArtifactCopies(folder.parent / "dispatcher", source)
    (worker,) = RemoteHost(machines(kind), plan, copies).workers
    await worker.open(WARM_UP)
    try:
        async with asyncio.timeout(GUARD):
            await worker.ready()
            yield worker
    finally:
        await worker.close()


async def told(worker, digests):
    outcome = await worker.run(run_of("read", digests=digests))
    assert isinstance(outcome, Returned), outcome
    return json.loads(outcome.result.text)


def test_what_a_run_reads_is_there_with_its_parts_and_comes_but_once(kind, tmp_path):
    async def story():
        source = Stored(SCENE, MESH, TEXTURE, EMPTY, faults=1)
        async with working(kind, source, tmp_path / "host") as worker:
            assert (await told(worker, ALL))["sizes"] == [None] * 4
            await worker.bring([SCENE.digest])
            found = await told(worker, ALL)
            assert found["sizes"] == [2, len(MESH.content), 10, 0]
            # Machines have folders of their own, if their operators say so.
            assert (found["folder"] == str(tmp_path / "host")) is (kind == "hosted")
            asked = len(source.asked)
            await worker.bring([SCENE.digest])
            assert (await told(worker, ALL))["sizes"][0] == 2
            assert len(source.asked) == asked

    asyncio.run(story())


def test_what_a_run_has_made_is_with_the_dispatcher_when_it_has_ended(kind, tmp_path):
    async def story():
        async with working(kind, Stored(), tmp_path / "host") as worker:
            outcome = await worker.run(run_of("make", sizes=[5_000_000, 0, 7]))
            assert isinstance(outcome, Returned)
            digests = json.loads(outcome.result.text)["digests"]
            paths = [artifact_path(tmp_path / "dispatcher", digest) for digest in digests]
            assert [path.stat().st_size for path in paths] == [5_000_000, 0, 7]
            contents = [Artifact(path.read_bytes()).digest for path in paths]
            assert contents == digests

    asyncio.run(story())


def test_what_is_not_stored_is_left_out(kind, tmp_path):
    async def story():
        async with working(kind, Stored(TEXTURE), tmp_path / "host") as worker:
            missing = Artifact(b"nowhere").digest
            await worker.bring([missing, TEXTURE.digest])
            assert (await told(worker, [missing, TEXTURE.digest]))["sizes"] == [None, 10]

    asyncio.run(story())


def test_a_run_that_waits_for_what_it_reads_can_be_canceled(kind, tmp_path):
    async def story():
        async with working(kind, Stored(SCENE, faults=10**6), tmp_path / "host") as worker:
            await worker.bring([SCENE.digest])
            running = asyncio.create_task(worker.run(run_of("read", digests=[])))
            await asyncio.sleep(0.1)
            worker.cancel(0.1)
            assert await asyncio.wait_for(running, GUARD) == Terminated()
            await worker.bring([])
            assert (await told(worker, []))["sizes"] == []

    asyncio.run(story())


def test_a_machine_that_cannot_keep_them_has_crashed_for_the_run(tmp_path):
    async def story():
        (tmp_path / "host").write_text("no folder")
        async with working("hosted", Stored(TEXTURE), tmp_path / "host") as worker:
            await worker.bring([TEXTURE.digest])
            outcome = await worker.run(run_of("read", digests=[TEXTURE.digest]))
            assert isinstance(outcome, Crashed)
            assert "could not be copied" in replace(outcome).reason

    asyncio.run(story())
