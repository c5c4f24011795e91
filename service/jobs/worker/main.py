"""What runs in a worker's process. Light: the forkserver imports it before any task."""

import gc
import json
import logging
import os
import socket
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from service.jobs.host_folder import set_host_folder
from service.jobs.worker.context import PipeContext, SilentContext
from service.jobs.worker.memory import limit_own
from service.jobs.worker.network import leave_network
from service.jobs.worker.parent_watch import exit_with_parent
from service.jobs.worker.protocol import Message, MessageKind, MessagePipe, two_parts
from service.jobs.worker.run_task import TaskEnd, run_task
from service.telemetry.ids import with_ids
from service.telemetry.logs import LogTerms, configure_logs

_CRASH_CODE = 70
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Terms:
    """Limits within which a process works.

    Attributes:
        niceness: How far it lets others go before (nice(2)), 0 to 19.
        memory: What it may use [bytes]; None for all that there is.
        memory_grace: How long a task may take to end by itself once it uses more [s].
        is_offline: Whether it is to reach no network, if the kernel has a way.
        logs: How it logs; None to leave that as it is.
    """

    niceness: int = 0
    memory: int | None = None
    memory_grace: float = 0.0
    is_offline: bool = False
    logs: LogTerms | None = None


def serve(
    end: socket.socket, parent: Connection, folder: Path | None, warm_up: str | None, terms: Terms
) -> None:
    """Run tasks one after the other until the other end is gone.

    Args:
        end: To the worker.
        parent: When its other end closes, this process ends at once.
        folder: That the workers of this host share; None if its tasks read no artifacts.
        warm_up: A task to run first, with an empty payload.
        terms: Of the work.
    """
    exit_with_parent(parent)
    if terms.logs is not None:
        configure_logs(terms.logs)
    network = leave_network() if terms.is_offline else None
    gc.freeze()
    gc.enable()
    os.nice(terms.niceness)
    if terms.memory is not None:
        limit_own(terms.memory)
    if folder is not None:
        set_host_folder(folder)
    try:
        _run_tasks(MessagePipe(end), network, warm_up)
    except Exception:  # noqa: BLE001  (and no more)
        # Not left to multiprocessing, which would print it line by line.
        _log.critical("a worker ends", exc_info=True)
        os._exit(_CRASH_CODE)


def _run_tasks(pipe: MessagePipe, network: str | None, warm_up: str | None) -> None:
    fault = ""
    if warm_up is not None:
        warm_up_end = run_task(warm_up, "{}", SilentContext())
        if warm_up_end.kind is not MessageKind.RESULT:
            fault = warm_up_end.text
    pipe.send(Message(MessageKind.READY, 0, two_parts(network or "", fault)))
    while (message := pipe.receive()) is not None:
        if message.kind is MessageKind.TASK:
            head, payload = message.parts
            task, ids = json.loads(head)
            with with_ids(ids):
                ended = run_task(task, payload, PipeContext(pipe, message.token))
            _report(pipe, message.token, ended)


def _report(pipe: MessagePipe, token: int, ended: TaskEnd) -> None:
    """Say how a task ended; after a crash this process is not to be trusted any more."""
    is_result = ended.kind is MessageKind.RESULT
    body = two_parts(ended.summary, ended.text) if is_result else ended.text.encode()
    pipe.send(Message(ended.kind, token, body))
    if ended.kind is MessageKind.CRASH:
        os._exit(_CRASH_CODE)
