"""forkserver(): the process that workers are forked off.

Light: a server starts it before it imports what itself needs.
"""

import multiprocessing
from collections.abc import Sequence
from typing import Any


def forkserver(preload: Sequence[str]) -> Any:
    """Return the context that forks workers off a server which has imported some modules.

    There is one such server per process: the modules that are named first count.
    """
    context: Any = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([
        "service.jobs.worker.disable_gc",
        "service.jobs.worker.main",
        *preload,
    ])
    return context
