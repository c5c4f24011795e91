"""Certification failures in words: why no candidate motion was certified."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate, Check
from planning.errors import NotCertified


def not_certified(
    failed: Certificate | None, refused: Sequence[str], trajectory: TimedTrajectory | None
) -> NotCertified:
    """Return the error `NotCertified` with the failed checks of the last refused motion.

    Args:
        failed: Certificate of the last refused motion; None if it has none.
        refused: Reason for each refusal, one line per motion.
        trajectory: The last refused motion: where each check fails; None if there is none.
    """
    checks = [] if failed is None else failed.failed
    message = f"none of {len(refused)} candidate motions passed the certifier; the last failed "
    message += ", ".join(describe_check(check) for check in checks)
    return NotCertified(
        message, {"refused": list(refused), "checks": _evidence(checks, trajectory)}
    )


def failed_checks(certificate: Certificate) -> str:
    """Return a one-line summary of the failed checks and the instants of failure."""
    return ", ".join(f"{check.name} {check.where}".rstrip() for check in certificate.failed)


def describe_check(check: Check) -> str:
    """Return one failed check in words."""
    value = f"{check.value:.4g}" if check.unit == "1" else f"{check.value:.4g} {check.unit}"
    location = f"{check.where} at" if check.where else "at"
    return f"{check.name} ({value}, bound {check.bound:.4g}, {location} {check.time:.3f} s)"


def _evidence(checks: Sequence[Check], trajectory: TimedTrajectory | None) -> list[dict[str, Any]]:
    """Return checks by their fields, and where the motion is then [rad or m]."""
    names = ("name", "value", "bound", "unit", "where", "time")
    found = [{name: getattr(check, name) for name in names} for check in checks]
    if trajectory is None:
        return found
    places = trajectory.positions(np.array([check.time for check in checks])).tolist()
    return [{**check, "positions": q} for check, q in zip(found, places, strict=True)]
