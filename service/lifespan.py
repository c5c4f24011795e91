"""open_services(): store, dispatcher and workers, for as long as the server runs."""

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable, Coroutine, Sequence
from contextlib import asynccontextmanager
from functools import partial
from typing import Any

from anyio import to_thread
from sqlalchemy import Connection

from service.api.middleware.client_disconnect import call_for_client
from service.executions.gripping.grasp_keeper import GraspKeeper
from service.executions.measured import keep_end, open_motions
from service.executions.proofs.second_looks import SecondLooks
from service.executions.proofs.verdicts import judge
from service.executions.replanning.new_plan import Terms as PlanningTerms
from service.executions.replanning.replanner import Replanner
from service.executions.waiting_line import WaitingLine
from service.executions.watching.contact_watch import ContactWatch
from service.jobs.artifacts import ArtifactCopies
from service.jobs.dispatch.dispatcher import Dispatcher
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.dispatch.observer import Observer
from service.jobs.dispatch.scheduling.queue import JobQueue, Share
from service.jobs.dispatch.scheduling.worker_pool import WorkerPool
from service.jobs.hosts.plan import HostPlan, own_version
from service.jobs.hosts.ray_hosts import RayHosts
from service.jobs.hosts.remote_host import RemoteHost
from service.jobs.job import LoggedEvent
from service.jobs.service import JobService
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import keep_off_loops, open_engine
from service.jobs.task_calls import CallTerms
from service.jobs.worker.assignment import Worker
from service.jobs.worker.main import Terms
from service.jobs.worker.process_worker import ProcessWorker
from service.jobs.worker.thread_worker import ThreadWorker
from service.retention import Retention
from service.scenes.job_spec import PREFIXES
from service.scenes.store.file_cleanup import Sweeper
from service.scenes.store.scene_store import SceneStore
from service.scenes.tasks import Library
from service.settings import Settings
from service.versions import versions
from service.webhooks.delivery import DeliveryTerms, WebhookDelivery
from service.webhooks.store import WebhookStore
from service.workers import PRELOAD, WARM_UP, import_tasks

# In the order in which they are counted.
_QUEUES = ("plan", "query", "execution", "regions")
# Workers for short questions only: they go on while scenes are loaded.
_RESERVED = 1


@asynccontextmanager
async def open_services(
    settings: Settings,
    on_taken: Callable[[], None],
    observer: Observer | None = None,
) -> AsyncGenerator[tuple[JobService, SceneStore, WebhookStore]]:
    """Run jobs from here on, or have the server run them that leads those of the database.

    What an earlier leader left is taken up again.

    Args:
        settings: How the service runs.
        on_taken: Called when another server has taken the database over.
        observer: Hears of what the dispatcher does.

    Raises:
        DatabaseInUse: Another server works on this database, which cannot be shared.
    """
    await to_thread.run_sync(partial(settings.data_dir.mkdir, parents=True, exist_ok=True))
    engine = open_engine(settings.url)
    keep_off_loops(engine)
    store = JobStore(engine, versions())
    queues = _queues(settings, ArtifactCopies(settings.folder, store.artifacts))
    lock = DispatcherLock(engine)
    grasps = GraspKeeper()
    dispatcher = Dispatcher(store, lock, queues, on_taken=on_taken, observer=observer)
    dispatcher.conclusion = grasps
    if settings.engine == "inline":
        await to_thread.run_sync(import_tasks)
    scenes = SceneStore(engine, settings.folder, _library(settings))
    webhooks = WebhookStore(engine)
    delivery = WebhookDelivery(webhooks, _delivery_terms(settings))
    store.on_event = partial(_note, to=(keep_end, delivery.note))  # what recovery ends, too
    try:
        await dispatcher.start(None if settings.engine == "inline" else WARM_UP)
        try:
            await scenes.open()  # the leader has brought the database up to date
            terms = CallTerms(settings.query_timeout, settings.queue_timeout, call_for_client)
            jobs = JobService(store, dispatcher, prefixes=PREFIXES, queues=_QUEUES, terms=terms)
            replanner = Replanner(jobs, scenes, settings)
            looks = _connect(scenes, jobs, replanner)
            grasps.open(scenes, jobs)
            sweeper = Sweeper(engine, settings.data_dir, settings.owner)
            sweeper.ask()
            scenes.on_delete = jobs.on_delete = sweeper.ask
            retain = Retention(store, settings.retention_days, sweeper.ask)
            line = _once_leading(dispatcher, WaitingLine(scenes, PlanningTerms(jobs, settings)).run)
            watch = _once_leading(dispatcher, ContactWatch(jobs).run)
            own = sweeper.run(), looks.run(), delivery.run()
            async with (
                _meanwhile(*own, _once_leading(dispatcher, retain.run), line, watch),
                replanner,
            ):
                yield jobs, scenes, webhooks
        finally:
            await dispatcher.stop()
    finally:
        await to_thread.run_sync(engine.dispose)


def _connect(scenes: SceneStore, jobs: JobService, replanner: Replanner) -> SecondLooks:
    """Have scenes know what moves in them, and what moves know of their edits."""
    looks = SecondLooks(scenes)
    scenes.moving = partial(open_motions, jobs=jobs)
    scenes.verdicts = partial(judge, scenes=scenes, jobs=jobs, replanner=replanner, looks=looks)
    scenes.latest.on_change = jobs.wake
    return looks


def _note(
    connection: Connection,
    event: LoggedEvent,
    to: Sequence[Callable[[Connection, LoggedEvent], None]],
) -> None:
    for each in to:
        each(connection, event)


async def _once_leading(dispatcher: Dispatcher, work: Callable[[], Awaitable[None]]) -> None:
    """Do work that one server of a database does for all."""
    await dispatcher.leads.wait()
    await work()


@asynccontextmanager
async def _meanwhile(*work: Coroutine[Any, Any, None]) -> AsyncGenerator[None]:
    """Have work done in the background, and cancel it at the end."""
    tasks = [asyncio.get_running_loop().create_task(each) for each in work]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def _delivery_terms(settings: Settings) -> DeliveryTerms:
    return DeliveryTerms(settings.webhook_private_addresses, settings.webhook_failure_days)


def _library(settings: Settings) -> Library:
    # Where links lead is asked of the disk once, not for each task.
    return Library(
        model_roots=[str(root.resolve()) for root in settings.model_roots],
        allow_paths=settings.may_load_paths,
    )


# How long a canceled job may take to end by itself [s]: a robot comes to rest on its path first.
_CANCEL_GRACE = {"plan": 0.25, "query": 0.25, "execution": 5.0, "regions": 0.25}


def _queues(settings: Settings, copies: ArtifactCopies) -> dict[str, JobQueue]:
    """Return the queues: executions have workers of their own, all else shares a pool.

    A scene that was loaded for one is warm for all of them. Queues of a pool do not wait for each
    other: it has as many workers as they may use together.
    """
    hosts = settings.ray_hosts if settings.engine == "ray" else 1
    reserved = _RESERVED * hosts
    shares = {
        "query": Share(settings.query_slots * hosts + reserved, reserved),
        "plan": Share(settings.plan_slots * hosts),
        "regions": Share(settings.regions_slots * hosts),
    }
    count = sum(share.max_running or 0 for share in shares.values())
    memory, logs, grace = settings.worker_memory, settings.logs, _CANCEL_GRACE["execution"]
    planning = Terms(settings.niceness, memory, is_offline=True, logs=logs)
    # Executions go on while something is planned; OMPL and Drake take turns.
    # A controller of a robot is reached over the network.
    moving = Terms(0, memory, grace, is_offline=not settings.ur_hosts, logs=logs)
    on_each = (count // hosts * [planning], settings.execution_slots * [moving])
    shared, own = _workers(settings, copies, *on_each)
    pool = WorkerPool(shared)
    queues = {name: _queue(settings, name, pool, share) for name, share in shares.items()}
    return {**queues, "execution": _queue(settings, "execution", WorkerPool(own), None)}


def _queue(settings: Settings, name: str, pool: WorkerPool, share: Share | None) -> JobQueue:
    return JobQueue(name, pool, settings.max_queued, _CANCEL_GRACE[name], share=share)


def _workers(
    settings: Settings, copies: ArtifactCopies, planning: list[Terms], moving: list[Terms]
) -> tuple[Sequence[Worker], Sequence[Worker]]:
    """Return workers that plan and workers that move robots, by their terms on each machine."""
    if settings.engine == "inline":
        exclusive = [ThreadWorker(copies, is_exclusive=True) for _ in planning]
        return exclusive, [ThreadWorker(copies, is_exclusive=False) for _ in moving]
    if settings.engine == "process":
        local = [ProcessWorker(PRELOAD, terms, copies) for terms in (*planning, *moving)]
        return local[: len(planning)], local[len(planning) :]
    machines = RayHosts(settings.ray_address or "")
    terms = (*planning, *moving)
    plan = HostPlan(PRELOAD, WARM_UP, terms, own_version(), str(copies.folder))
    hosts = [RemoteHost(machines, plan, copies) for _ in range(settings.ray_hosts)]
    remote = [host.workers for host in hosts]
    return (
        [worker for each in remote for worker in each[: len(planning)]],
        [worker for each in remote for worker in each[len(planning) :]],
    )
