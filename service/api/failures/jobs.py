"""Evidence of what goes wrong with jobs and their workers, whatever they do."""

from typing import NotRequired, TypedDict

from pydantic import with_config

from service.api.document.known_values import QueueName
from service.api.failures.parts import OPEN


@with_config(OPEN)
class QueueFullEvidence(TypedDict):
    """Number of jobs in a queue that is full."""

    queue: QueueName
    """Name of the queue"""
    bound: int
    """Number of jobs that may wait"""
    queued: NotRequired[int]
    """Number of jobs that wait"""
    retry_after: float
    """Time after which to ask again [s]"""


@with_config(OPEN)
class QueueTimeoutEvidence(TypedDict):
    """Time that a question waited for a worker."""

    queue: QueueName
    """Name of the queue"""
    waited: float
    """Time that the question waited [s]"""
    queued: int
    """Number of questions that wait there"""
    retry_after: float
    """Time after which to ask again [s]"""


@with_config(OPEN)
class IdempotencyEvidence(TypedDict):
    """Resource that the first request with the key made."""

    key: str
    """The key"""
    job: NotRequired[str]
    """Id of the plan, the regions or the execution"""
    scene: NotRequired[str]
    """Id of the scene"""
    batch: NotRequired[str]
    """Id of the batch"""
    webhook: NotRequired[str]
    """Id of the webhook"""


@with_config(OPEN)
class InUseEvidence(TypedDict):
    """Resource that is not deleted, and what uses it."""

    id: str
    """Id of the resource"""
    used_by: str
    """Id of what uses it and has not ended"""


@with_config(OPEN)
class JobIdEvidence(TypedDict):
    """Job that does not exist."""

    id: str
    """Id that was given"""


@with_config(OPEN)
class DatabaseEvidence(TypedDict):
    """Which database another server works on."""

    database: str
    """Its address, without the password"""


@with_config(OPEN)
class DatabaseRevisionEvidence(TypedDict):
    """Which revision a database has."""

    revision: str
    """Of the database"""
    newest: str
    """The newest one that this server knows"""


@with_config(OPEN)
class ForeignTableEvidence(TypedDict):
    """Which table is not one of this program."""

    table: str
    """Name of the table"""
    missing: list[str]
    """Columns that it lacks"""


@with_config(OPEN)
class BackupEvidence(TypedDict, total=False):
    """Which file is no backup."""

    file: str
    """Its path"""
    member: str
    """What in it is wrong"""


@with_config(OPEN)
class DatabaseTakenEvidence(TypedDict):
    """Server that has the database."""

    epoch: int
    """Epoch of this server"""
    latest: int | None
    """Epoch of the server that has the database now"""


@with_config(OPEN)
class StorageEvidence(TypedDict):
    """Why nothing is written."""

    reason: str
    """Message of the database or the file system"""
    retry_after: float
    """Time after which to ask again [s]"""


@with_config(OPEN)
class WorkerCrashedEvidence(TypedDict):
    """How the worker's process died."""

    attempts: int
    """Number of times that the job was started"""
    exit_code: int | None
    """Exit code; negative where a signal ended the worker, null if unknown"""
    signal: NotRequired[str | None]
    """Name of the signal"""
    reason: NotRequired[str]
    """Last message of the worker, or empty"""
    during: NotRequired[str]
    """The stage that it told last"""


@with_config(OPEN)
class WorkerSilentEvidence(TypedDict):
    """Time for which the worker's process said nothing."""

    silence: float
    """Seconds"""
    attempts: NotRequired[int]
    """Number of times that the job was started"""
    during: NotRequired[str]
    """The stage that it told last"""


@with_config(OPEN)
class HostLostEvidence(TypedDict):
    """Machine that was lost."""

    host: str
    """Address of the machine and the first digits of its id"""
    attempts: NotRequired[int]
    """Number of times that the job was started"""
    during: NotRequired[str]
    """The stage that it told last"""


@with_config(OPEN)
class MemoryEvidence(TypedDict):
    """Memory that the worker used."""

    used: int
    """Largest memory that was seen [bytes]"""
    bound: int
    """Memory that the worker may use [bytes]"""
    attempts: NotRequired[int]
    """Number of times that the job was started"""
    during: NotRequired[str]
    """The stage that it told last"""


@with_config(OPEN)
class RestartEvidence(TypedDict):
    """Number of times that the job was started."""

    attempts: int
    """Number of times that it was started"""
    reason: NotRequired[str]
    """Reason why the server ended it, if it did"""
    during: NotRequired[str]
    """The stage that it told last"""


@with_config(OPEN)
class InternalErrorEvidence(TypedDict):
    """A fault of ours; the log has the rest."""

    exception: NotRequired[str]
    """Class of the exception"""
    reference: NotRequired[str]
    """Reference under which the server's log says more"""
    during: NotRequired[str]
    """The stage that it told last"""
