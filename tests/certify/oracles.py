"""Choice between the two clearance proofs: the kernel's, or Drake's alone."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace

from planning.world.drake_model import DrakeModel

_USES_KERNEL = ContextVar("uses_kernel", default=True)


@contextmanager
def oracle(*, kernel: bool) -> Iterator[None]:
    """Choose the proof for every model that goes through `for_oracle`."""
    token = _USES_KERNEL.set(kernel)
    try:
        yield
    finally:
        _USES_KERNEL.reset(token)


def for_oracle(model: DrakeModel) -> DrakeModel:
    """Return the model for the chosen proof."""
    return model if model.uses_kernel == _USES_KERNEL.get() else without_kernel(model)


def without_kernel(model: DrakeModel) -> DrakeModel:
    """Return the same model for Drake alone."""
    return replace(model, uses_kernel=False)
