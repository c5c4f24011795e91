"""How many durable jobs a second there are that do nothing, without HTTP: what the engine costs."""

import asyncio
import tempfile
import time
from pathlib import Path

from benchmarks.service_load.measure import Measure
from service.jobs.context import TaskContext
from service.jobs.dispatch.dispatcher import Dispatcher
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.job import JobSpec
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine
from service.jobs.task import Task, TaskModel
from service.jobs.worker.process_worker import ProcessWorker

_HERE = __name__


class Nothing(TaskModel):
    """What the job is given and gives."""


NOOP = Task("benchmark_noop", Nothing, Nothing, queue="plan")
_LONGEST = 300.0


@NOOP.runs
def noop(payload: Nothing, context: TaskContext) -> Nothing:
    """Do nothing, in a worker."""
    del context
    return payload


def noops(count: int, slots: int) -> Measure:
    """Have jobs done that were all asked for at once, from an SQLite database on the disk.

    Args:
        count: How many.
        slots: Processes that do them.
    """
    with tempfile.TemporaryDirectory(prefix="wp-bench-") as folder:
        return asyncio.run(_done(Path(folder), count, slots))


async def _done(folder: Path, count: int, slots: int) -> Measure:
    measure = Measure(f"durable jobs that do nothing, {slots} workers")
    engine = open_engine(f"sqlite:///{folder / 'jobs.sqlite'}")
    most = 2 * count  # one client alone has nine tenths of that
    queues = {"plan": JobQueue("plan", [ProcessWorker([_HERE]) for _ in range(slots)], most)}
    dispatcher = Dispatcher(JobStore(engine, {}), DispatcherLock(engine), queues)
    await dispatcher.start()

    async def one() -> None:
        began = time.perf_counter()
        job = await dispatcher.submit(JobSpec("plan", NOOP.name, {}))
        ended = await dispatcher.wait(job.id, _LONGEST)
        if ended.state == "succeeded":
            measure.seconds.append(time.perf_counter() - began)
        else:
            measure.faults.append(str(ended.state))

    try:
        await asyncio.gather(*(one() for _ in range(slots)))  # every worker is there by then
        measure.seconds.clear()
        began = time.perf_counter()
        await asyncio.gather(*(one() for _ in range(count)))
        measure.rate = measure.num_done / (time.perf_counter() - began)
    finally:
        await dispatcher.stop()
        engine.dispose()
    return measure
