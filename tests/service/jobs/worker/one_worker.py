"""A worker of this machine that is ready, for as long as a test needs it."""

import asyncio
from contextlib import asynccontextmanager

from service.jobs.worker.process_worker import ProcessWorker
from tests.service.jobs.conftest import GUARD, TASKS, WARM_UP


@asynccontextmanager
async def open_worker(terms):
    worker = ProcessWorker([TASKS], terms)
    await worker.open(WARM_UP)
    try:
        async with asyncio.timeout(GUARD):
            await worker.ready()
            yield worker
    finally:
        await worker.close()
