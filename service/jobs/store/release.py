"""Release of jobs that wait for their robots: they enter their scene, and may be run."""

from sqlalchemy import update

from service.jobs.errors import Overtaken
from service.jobs.job import Job, JobSpec
from service.jobs.json_text import decoded
from service.jobs.outline import without
from service.jobs.states import JobState
from service.jobs.store.entries import lock_entries, read_entries, write_released
from service.jobs.store.job_store import JobStore
from service.jobs.store.queries import read_job
from service.jobs.store.sql.notifications import note_change
from service.jobs.store.sql.tables import bodies, jobs, summaries
from service.jobs.task import outline_of


def release(store: JobStore, identifier: str, spec: JobSpec) -> Job | None:
    """Let a job that waits for its robots enter its scene, and return it; None if it has ended.

    Args:
        store: Has the job.
        identifier: Of the job.
        spec: With its payload by now, and the number of entries that it follows.

    Raises:
        Overtaken: Another job has entered the scene, or is before it.
    """
    scene = spec.scene or ""
    waits = (jobs.c.id == identifier) & (jobs.c.state == JobState.QUEUED.value)
    with store.transaction(is_durable=True) as connection:
        if not lock_entries(connection, scene, spec.follows, more=True):
            raise Overtaken
        changed = update(jobs).where(waits & ~jobs.c.is_cancel_requested)
        now = changed.values(world_digest=spec.world_digest)
        if connection.execute(now).rowcount == 0:
            return None
        if not read_entries(connection, spec.queue, scene).is_free_for(identifier):
            raise Overtaken
        write_released(connection, identifier)
        whole = decoded(spec.payload)
        short = without(whole, outline_of(spec.task).payload)
        for table, payload in ((bodies, whole), (summaries, short)):
            connection.execute(
                update(table).where(table.c.job == identifier).values(payload=payload)
            )
        note_change(connection, scene)
        note_change(connection, identifier)
        return read_job(connection, identifier)
