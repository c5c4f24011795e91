"""Native module: the compiled kernel, if it was built."""

import logging
from functools import cache
from importlib import import_module
from types import ModuleType

_LOG = logging.getLogger(__name__)


@cache
def native() -> ModuleType | None:
    """Return the native module; None, with one warning in the log, if it was not built."""
    try:
        return import_module("planning.kernel._native")
    except ImportError as fault:
        _LOG.warning(
            "the native kernel is not available (%s): Drake computes everything, more slowly", fault
        )
        return None


def verdict_numbers(module: ModuleType) -> tuple[int, int, int]:
    """Return the numbers of free, colliding and unsure in the kernel's arrays of verdicts."""
    kinds = module.Verdict
    return kinds.FREE.value, kinds.COLLIDING.value, kinds.UNSURE.value


def kernel_name() -> str:
    """Return the instruction set that the kernel runs on, or "none"."""
    module = native()
    return module.batch_kernels()[0] if module else "none"
