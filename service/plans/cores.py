"""Cores: whether a plan may make its attempts side by side."""

from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from planning.parallel.core_leases import CoreLeases
from planning.parallel.fork_pool import ForkPool


@contextmanager
def own_core(cores: Mapping[str, Any] | None) -> Generator[ForkPool | None]:
    """Take a core for a plan, so that others see it busy, and give the pool of the idle ones.

    A plan runs whether there is a core for it or not.

    Args:
        cores: With `folder` and `count`; None where attempts are made one after another.
    """
    if cores is None:
        yield None
        return
    shared = CoreLeases(Path(cores["folder"]), cores["count"])
    with shared.lease(1):
        yield ForkPool(shared)
