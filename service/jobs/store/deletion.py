"""Deletion of jobs that have ended, with all that was recorded of them.

Clients ask for it, and so does retention. What a job that waits or runs was asked for by name
stays until that has ended. An idempotency key is free again once its job is deleted.
"""

import re
from collections.abc import Mapping

from sqlalchemy import Connection, delete, select

from planning.errors import IllegalTransition
from service.jobs.errors import JobInUse, UnknownJob
from service.jobs.json_text import encode
from service.jobs.states import JobState
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.tables import bodies, events, job_robots, jobs, makers, summaries

# Others write meanwhile: no transaction takes long.
_EVENTS_AT_ONCE = 2000
ENDED = [state.value for state in JobState if state.is_final]
_NAMED = re.compile(r'"((?:pln|exe|reg)_[0-9a-f]+)"')


def delete_on_request(store: JobStore, *identifiers: str) -> None:
    """Delete jobs that have ended, all of them or none.

    Raises:
        UnknownJob: There is no such job.
        IllegalTransition: One has not ended.
        JobInUse: A job that has not ended names it.
    """
    with store.transaction(is_durable=False) as connection:
        users = named_by_open(connection)
        for identifier in identifiers:
            _check_ended(connection, identifier)
            if identifier in users:
                raise JobInUse.of(identifier, users[identifier])
    for identifier in identifiers:
        delete_job(store, identifier)


def delete_job(store: JobStore, identifier: str) -> None:
    """Delete a job that has ended, its events first and in portions: an hour of motion has 70,000.

    What is interrupted can be done again: the job itself goes last.
    """
    number = 0
    while True:
        number += _EVENTS_AT_ONCE
        these = (events.c.job == identifier) & (events.c.number <= number)
        with store.transaction(is_durable=False) as connection:
            gone = connection.execute(delete(events).where(these)).rowcount
            if gone == 0:
                for table in (bodies, summaries, makers, job_robots):
                    connection.execute(delete(table).where(table.c.job == identifier))
                connection.execute(delete(jobs).where(jobs.c.id == identifier))
                return


def named_by_open(connection: Connection) -> Mapping[str, str]:
    """Return the ids in what jobs that wait or run were asked for, and the job of each."""
    query = select(jobs.c.id, summaries.c.payload).join(summaries, jobs.c.id == summaries.c.job)
    found = connection.execute(query.where(jobs.c.state.not_in(ENDED)))
    return {name: user for user, payload in found for name in _NAMED.findall(encode(payload))}


def _check_ended(connection: Connection, identifier: str) -> None:
    query = select(jobs.c.state).where(jobs.c.id == identifier)
    state = connection.execute(query).scalar_one_or_none()
    if state is None:
        raise UnknownJob.of(identifier)
    if state not in ENDED:
        message = f"{identifier} is {state}: cancel it, and delete it once it has ended"
        raise IllegalTransition(message, {"state": state, "event": "delete", "legal": ["cancel"]})
