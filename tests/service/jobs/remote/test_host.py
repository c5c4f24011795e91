"""A host ends what it runs when nothing asks for it, and is lost when it does not answer."""

import asyncio
from contextlib import asynccontextmanager

import pytest

from service.jobs.hosts.host import WorkerHost
from service.jobs.hosts.messages import HostMessage, HostMessageKind, pack, unpack
from service.jobs.hosts.outbox import WINDOW, Outbox, OutboxSink
from service.jobs.hosts.plan import HostPlan, HostTimeouts, own_version
from service.jobs.hosts.remote_host import RemoteHost
from service.jobs.json_text import Encoded
from service.jobs.outcome import Lost, Returned
from service.jobs.worker.main import Terms
from tests.profiles import only_campaign
from tests.service.jobs.conftest import GUARD, TASKS, WARM_UP
from tests.service.jobs.remote.machines import Machines
from tests.service.jobs.worker.test_process_worker import Sink, is_alive, run_of


def plan(**timeouts):
    return HostPlan((TASKS,), WARM_UP, (Terms(),), own_version(), timeouts=HostTimeouts(**timeouts))


async def said(host, kind):
    """The first message of a kind from now on."""
    async with asyncio.timeout(GUARD):
        while True:
            for message in unpack(await host.collect()):
                if message.kind is kind:
                    return message


@only_campaign("7 s")
def test_a_host_that_nothing_asks_ends_what_it_runs():
    """A dispatcher that is gone prolongs nothing."""

    async def story():
        abandoned = asyncio.Event()
        host = WorkerHost(plan(abandoned=0.5), on_abandoned=abandoned.set)
        await host.open()
        await said(host, HostMessageKind.READY)
        run = b'{"task":"fake.hang","time_limit":null,"controls":{},"artifacts":[]}\n{}'
        host.deliver(pack([HostMessage(HostMessageKind.RUN, 0, 1, run)]))
        event = await said(host, HostMessageKind.EVENT)
        pid = int(event.body.decode().split('"pid":')[1].split(",")[0])
        for _ in range(5):  # it waits for news while it is asked for them
            await asyncio.sleep(0.2)
            await host.collect()
        assert is_alive(pid)
        await asyncio.wait_for(abandoned.wait(), GUARD)
        assert not is_alive(pid)

    asyncio.run(story())


class Silent(Machines):
    """Machines whose answers stop when a test says so, as those of a network that is cut."""

    def __init__(self):
        super().__init__(2)
        self.is_cut = False

    @asynccontextmanager
    async def host(self, plan):
        async with super().host(plan) as line:
            collect = line.collect

            async def cut_off():
                batch = await collect()
                if self.is_cut:
                    self.is_cut = False
                    await asyncio.Event().wait()
                return batch

            line.collect = cut_off
            yield line


def test_a_host_that_does_not_answer_is_lost_and_another_one_takes_its_place():
    async def story():
        machines = Silent()
        remote = RemoteHost(machines, plan(patience=0.05, lost=1.0))
        (worker,) = remote.workers
        await worker.open(WARM_UP)
        async with asyncio.timeout(GUARD):
            await worker.ready()
            before = worker.generation
            sink = Sink()
            running = asyncio.create_task(worker.run(run_of("spin", sink)))
            await sink.seen.wait()
            machines.is_cut = True
            assert await running == Lost("machine-0", has_begun=True)
            assert worker.fault == "machine-0 was lost"
            assert await worker.run(run_of("echo")) == Lost("machine-0", has_begun=False)
            await worker.ready()
            assert worker.generation > before
            assert worker.fault is None
            assert isinstance(await worker.run(run_of("echo")), Returned)
        await worker.close()
        assert not machines.hosts

    asyncio.run(story())


def test_a_host_that_speaks_nonsense_is_lost():
    async def story():
        machines = Machines()
        remote = RemoteHost(machines, plan())
        (worker,) = remote.workers
        await worker.open(WARM_UP)
        async with asyncio.timeout(GUARD):
            await worker.ready()
            host = machines.hosts["machine-0"]
            running = asyncio.create_task(worker.run(run_of("spin")))
            await asyncio.sleep(0)
            host._outbox.put(HostMessage(HostMessageKind.OUTCOME, 0, 1, b"what\n"))
            assert isinstance(await running, Lost)
        await worker.close()

    asyncio.run(story())


@pytest.mark.parametrize("is_update", [True, False])
def test_a_task_waits_while_too_many_of_its_events_are_on_their_way(is_update):
    async def story():
        outbox = Outbox()
        sink = OutboxSink(outbox, 3, 5)
        for i in range(WINDOW):
            sink.put("note", Encoded(str(i)), is_update=is_update)
        if is_update:  # which never wait
            await asyncio.wait_for(sink.wait_for_space(), GUARD)
            return
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(sink.wait_for_space(), 0.01)
        messages = unpack(await outbox.collect(GUARD))
        assert [message.parts for message in messages] == [("note", str(i)) for i in range(WINDOW)]
        sink.note_received(1)
        await asyncio.wait_for(sink.wait_for_space(), GUARD)

    asyncio.run(story())
