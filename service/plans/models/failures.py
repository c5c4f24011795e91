"""Our errors as the `failure` of a job."""

from typing import Any

from planning.errors import WayproofError
from service.api.models import Failure


def failure_wire(error: WayproofError) -> dict[str, Any]:
    """Return an error as `code`, `stage`, `detail`, `evidence`, `timings`."""
    return Failure.from_error(error).model_dump()
