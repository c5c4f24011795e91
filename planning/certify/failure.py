"""A refusal in words: why no motion was certified."""

from collections.abc import Sequence
from typing import Any

from planning.domain.report.certificate import Certificate, Check
from planning.errors import NotCertified


def not_certified(failed: Certificate | None, refused: Sequence[str]) -> NotCertified:
    """Return the failure that says what the last of some refused motions lacks.

    Args:
        failed: Its certificate; None if there was none.
        refused: What was wrong with each, a line for a motion.
    """
    checks = [] if failed is None else failed.failed
    message = f"none of {len(refused)} candidate motions passed the certifier; the last failed "
    message += ", ".join(describe_check(check) for check in checks)
    return NotCertified(message, {"refused": list(refused), "checks": _evidence(checks)})


def failed_checks(certificate: Certificate) -> str:
    """Return the failed checks and where they failed, in short."""
    return ", ".join(f"{check.name} {check.where}".rstrip() for check in certificate.failed)


def describe_check(check: Check) -> str:
    """Return a failed check as words."""
    value = f"{check.value:.4g}" if check.unit == "1" else f"{check.value:.4g} {check.unit}"
    place = f"{check.where} at" if check.where else "at"
    return f"{check.name} ({value}, bound {check.bound:.4g}, {place} {check.time:.3f} s)"


def _evidence(checks: Sequence[Check]) -> list[dict[str, Any]]:
    names = ("name", "value", "bound", "unit", "where", "time")
    return [{name: getattr(check, name) for name in names} for check in checks]
