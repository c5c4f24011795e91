"""run_task(): a task, wherever it runs, comes to an end that is always one of three."""

import logging
import secrets
from dataclasses import dataclass
from typing import Any

from planning.errors import WayproofError
from service.jobs.errors import InternalError
from service.jobs.json_text import encode_leniently
from service.jobs.task import task_named
from service.jobs.worker.protocol import MessageKind, dump_error

# Events are for people; whatever is larger belongs into the result.
MAX_EVENT = 64 * 1024
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class TaskEnd:
    """How a task ended.

    Attributes:
        kind: RESULT, FAILURE or CRASH.
        text: The result or the error as JSON; what ended the process.
        summary: Of a result, what lists show of it as JSON; empty for all.
    """

    kind: MessageKind
    text: str
    summary: str = ""


def run_task(task: str, payload: str, channel: Any) -> TaskEnd:
    """Carry the task of a name out with a payload (JSON), and say how it ended.

    What it should not raise is an InternalError. What a process should not outlive (an exit, an
    interrupt, memory that ran out) is a crash.
    """
    try:
        done = task_named(task).run(payload, channel)
        return TaskEnd(MessageKind.RESULT, done.text, done.summary)
    except WayproofError as error:
        return TaskEnd(MessageKind.FAILURE, dump_error(error))
    except MemoryError:
        return TaskEnd(MessageKind.CRASH, "MemoryError")
    except Exception as fault:  # noqa: BLE001  (the last edge: nothing may be lost)
        return TaskEnd(MessageKind.FAILURE, dump_error(_internal(fault)))
    except BaseException as fault:  # noqa: BLE001
        return TaskEnd(MessageKind.CRASH, f"{type(fault).__name__}: {fault}"[:500])


def event_text(data: dict[str, Any]) -> str:
    """Return the JSON text of an event's data; too much of it is left out, and that is said."""
    text = encode_leniently(data)
    if len(text) <= MAX_EVENT:
        return text
    kept = {name: data[name] for name in ("stage", "progress") if name in data}
    short = encode_leniently({**kept, "truncated": True, "bytes": len(text)})
    return short if len(short) <= MAX_EVENT else '{"truncated":true}'


def _internal(fault: BaseException) -> InternalError:
    """Return the error for a fault of ours; what it says of our code is for our log alone."""
    reference = secrets.token_hex(4)
    _log.error("a task failed (%s)", reference, exc_info=fault)
    kind = type(fault).__name__
    what = f"the task failed in a way that is our fault: {kind}; the server's log says more under "
    return InternalError(what + reference, {"exception": kind, "reference": reference})
