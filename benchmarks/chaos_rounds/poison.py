"""Poison: in workers that import this, some plans hang in native code or break their process.

The seed of a request says which. The workers of `poisoned_server` import this. What such a plan
does to them is real: while native code keeps the interpreter's lock, nothing else of Python runs.
"""

import ctypes
from typing import Any

from benchmarks.chaos_rounds.mix import HANGS, SEGFAULTS
from planning import plan
from service.plans import worker

_native = ctypes.PyDLL(None)


def plan_or_break(problem: Any, *arguments: Any, **options: Any) -> Any:
    """Return what `planning.plan` returns, unless the seed of the problem is one of poison."""
    if problem.seed == HANGS:
        mutex = ctypes.create_string_buffer(64)  # PTHREAD_MUTEX_INITIALIZER is zeros
        _native.pthread_mutex_lock(mutex)
        _native.pthread_mutex_lock(mutex)  # never returns, whatever signals come
    if problem.seed == SEGFAULTS:
        ctypes.string_at(0)
    return plan(problem, *arguments, **options)


worker.plan = plan_or_break
