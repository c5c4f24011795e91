"""Which of the two proofs of clearance judges: the kernel's, or Drake's alone."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace

from planning.world.drake_model import DrakeModel

_USES_KERNEL = ContextVar("uses_kernel", default=True)


@contextmanager
def oracle(*, kernel: bool) -> Iterator[None]:
    """Let one of them judge every model that goes through `judged_by_oracle`."""
    token = _USES_KERNEL.set(kernel)
    try:
        yield
    finally:
        _USES_KERNEL.reset(token)


def judged_by_oracle(model: DrakeModel) -> DrakeModel:
    """Return the model as the oracle in force shall see it."""
    return model if model.uses_kernel == _USES_KERNEL.get() else without_kernel(model)


def without_kernel(model: DrakeModel) -> DrakeModel:
    """Return the same model for Drake alone."""
    return replace(model, uses_kernel=False)
