"""join(): a server takes the database and brings it up to date, or finds that another one leads."""

import asyncio

from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.dispatch.leadership.timeouts import DatabaseTimeouts
from service.jobs.errors import DatabaseInUse
from service.jobs.store.job_store import JobStore

# Between two looks at tables that another server is about to make [s].
_LOOK = 0.1


async def join(store: JobStore, lock: DispatcherLock, timeouts: DatabaseTimeouts) -> bool:
    """Take the database and bring it up to date, or return that another server leads.

    Args:
        store: The record of jobs.
        lock: On the database.
        timeouts: How long that server may take to make the tables.

    Returns:
        Whether the lock is taken.

    Raises:
        DatabaseInUse: It cannot be shared, or that server is of another version.
    """
    until = asyncio.get_running_loop().time() + timeouts.tables
    while True:
        try:
            await asyncio.to_thread(lock.take)
            break
        except DatabaseInUse:
            if not store.is_shared:
                raise
            if await asyncio.to_thread(store.is_up_to_date):
                return False
        if asyncio.get_running_loop().time() > until:
            raise lock.of_other_version()
        await asyncio.sleep(_LOOK)
    try:
        store.set_epoch(lock.epoch)
        await asyncio.to_thread(store.open)
    except BaseException:
        await asyncio.to_thread(lock.release)
        raise
    return True
