"""Jobs that are submitted together are queued all, or none."""

import asyncio

import pytest

from service.jobs.errors import DatabaseUnavailable, QueueFull
from service.jobs.states import JobState
from tests.profiles import only_campaign
from tests.service.jobs.conftest import GUARD, running, spec


def batch(count, **more):
    first = spec("echo", batch="bat_1", **more)
    return [first, *(spec("echo", batch="bat_1") for _ in range(count - 1))]


def test_all_run_and_are_found_by_their_batch(tmp_path):
    async def story():
        async with running(tmp_path, inline=True) as (dispatcher, store):
            jobs = await dispatcher.submit_all(batch(5))
            await dispatcher.submit(spec("echo"))
            ends = [await dispatcher.wait(job.id, GUARD) for job in jobs]
            assert {job.state for job in ends} == {JobState.SUCCEEDED}
            assert [member.id for member in store.members_of("bat_1")] == [job.id for job in jobs]

    asyncio.run(story())


def test_a_queue_without_room_for_all_takes_none(tmp_path):
    async def story():
        async with running(tmp_path, inline=True, max_waiting=4) as (dispatcher, store):
            with pytest.raises(QueueFull) as refused:
                await dispatcher.submit_all(batch(5))
            assert refused.value.evidence["bound"] == 4
            assert store.members_of("bat_1") == []
            assert len(await dispatcher.submit_all(batch(4))) == 4

    asyncio.run(story())


def test_a_key_that_was_used_gives_the_first_job_again(tmp_path):
    async def story():
        async with running(tmp_path, inline=True) as (dispatcher, store):
            first, *_ = await dispatcher.submit_all(batch(3, key="k", request_digest="d"))
            both = await asyncio.gather(
                *(dispatcher.submit_all(batch(3, key="k", request_digest="d")) for _ in range(2))
            )
            assert [[job.id for job in jobs] for jobs in both] == [[first.id]] * 2
            assert len(store.members_of("bat_1")) == 3

    asyncio.run(story())


def test_of_two_at_once_with_one_key_one_is_made(tmp_path):
    async def story():
        async with running(tmp_path, inline=True) as (dispatcher, store):
            both = await asyncio.gather(
                *(dispatcher.submit_all(batch(3, key="k", request_digest="d")) for _ in range(2))
            )
            assert {jobs[0].id for jobs in both} == {store.members_of("bat_1")[0].id}
            assert len(store.members_of("bat_1")) == 3

    asyncio.run(story())


@only_campaign("5 s")
def test_a_full_disk_takes_none(tmp_path):
    async def story():
        disks = []
        async with running(tmp_path, inline=True, disks=disks) as (dispatcher, store):
            payload = {"text": "x" * 100_000}
            disks[0].fill()
            with pytest.raises(Exception) as refused:
                await dispatcher.submit_all([*batch(3), spec("echo", payload=payload)])
            assert isinstance(refused.value, DatabaseUnavailable) or "full" in str(refused.value)
            disks[0].free()
            assert store.members_of("bat_1") == []
            ends = await dispatcher.submit_all(batch(2))
            assert (await dispatcher.wait(ends[1].id, GUARD)).state is JobState.SUCCEEDED

    asyncio.run(story())
