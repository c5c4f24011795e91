"""open_desk(): store, dispatcher and slots, for as long as the server runs."""

import asyncio
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager
from functools import partial

from anyio import to_thread

from service.desk import LANES, Desk
from service.executions.settlement import settled
from service.jobs.database import keep_off_loops, open_engine
from service.jobs.dispatcher import Dispatcher
from service.jobs.inline_slot import InlineSlot
from service.jobs.lane import Lane
from service.jobs.ownership import Ownership
from service.jobs.slot import ProcessSlot, Slot
from service.jobs.store import JobStore
from service.plans.versions import versions
from service.scenes.shelf import SceneShelf
from service.scenes.store import SceneStore
from service.scenes.sweeping import Sweeper
from service.settings import Settings

# What the forkserver imports once, so that every worker has Drake and OMPL from its birth.
_PRELOAD = (
    "service.tasks.execute",
    "service.tasks.models",
    "service.tasks.plan",
    "service.tasks.planners",
    "service.tasks.queries",
    "service.tasks.regions",
    "service.tasks.scenes",
    "service.tasks.trajectories",
)
_WARM_UP = "service.tasks.warm:warm_up"


@asynccontextmanager
async def open_desk(
    settings: Settings, on_taken: Callable[[], None]
) -> AsyncGenerator[tuple[Desk, SceneShelf]]:
    """Run jobs from here on; what an earlier server left is taken up again.

    Args:
        settings: How the service runs.
        on_taken: Called when another server has taken the database over.

    Raises:
        DatabaseInUse: Another server works on this database.
    """
    await to_thread.run_sync(partial(settings.data_dir.mkdir, parents=True, exist_ok=True))
    engine = open_engine(settings.url)
    keep_off_loops(engine)
    store = JobStore(engine, versions())
    lanes = {name: _lane(settings, name) for name in LANES}
    dispatcher = Dispatcher(store, Ownership(engine), lanes, on_taken=on_taken)
    scenes = SceneStore(engine, settings.data_dir / "scenes")
    try:
        await to_thread.run_sync(scenes.open)
        await dispatcher.start(_WARM_UP if settings.engine == "process" else None)
        try:
            shelf = SceneShelf(scenes)
            desk = Desk(settings, store, dispatcher, shelf)
            shelf.settle = partial(settled, scenes=shelf, desk=desk)
            async with _swept(Sweeper(engine, settings.data_dir, settings.owner)) as sweeper:
                shelf.forgotten = sweeper.ask
                yield desk, shelf
        finally:
            await dispatcher.stop()
    finally:
        await to_thread.run_sync(engine.dispose)


@asynccontextmanager
async def _swept(sweeper: Sweeper) -> AsyncGenerator[Sweeper]:
    """Have a sweeper sweep once, and whenever it is asked to."""
    sweeper.ask()
    work = asyncio.get_running_loop().create_task(sweeper.run())
    try:
        yield sweeper
    finally:
        work.cancel()
        await asyncio.gather(work, return_exceptions=True)


# How long a canceled job may take to end by itself [s]: a robot comes to rest on its path first.
_CANCEL_GRACE = {"plan": 0.25, "query": 0.25, "execution": 5.0, "regions": 0.25}


def _lane(settings: Settings, name: str) -> Lane:
    count: int = getattr(settings, f"{name}_slots")
    slots = [_slot(settings, name) for _ in range(count)]
    return Lane(name, slots, settings.max_queued, _CANCEL_GRACE[name])


def _slot(settings: Settings, lane: str) -> Slot:
    if settings.engine == "inline":
        # Executions go on while something is planned; OMPL and Drake take turns.
        return InlineSlot(is_exclusive=lane != "execution")
    return ProcessSlot(_PRELOAD)
