"""Our errors as the `failure` of a job."""

from typing import Any

from planning.errors import WayproofError


def failure_wire(error: WayproofError) -> dict[str, Any]:
    """Return an error as `code`, `stage`, `detail`, `evidence`, `timings`."""
    return {
        "code": error.code,
        "stage": str(getattr(error, "stage", "")),
        "detail": error.detail,
        "evidence": error.evidence,
        "timings": dict(getattr(error, "timings", {})),
    }
