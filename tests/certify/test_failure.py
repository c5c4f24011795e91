"""Messages of failed checks: without a unit or a name where the check has none."""

import pytest

from planning.certify.failure import failed_checks, not_certified
from planning.domain.report.certificate import Certificate, Check


@pytest.mark.parametrize(
    ("check", "described", "named"),
    [
        (
            Check("steering car::base_joint", 1e5, 1.0001, "1", 0.0, False, "sideways", 0.3),
            "steering car::base_joint (1e+05, bound 1, sideways at 0.300 s)",
            "steering car::base_joint sideways",
        ),
        (
            Check("stop", 0.3761, 0.2, "s", 0.0, False, "", 0.372),
            "stop (0.3761 s, bound 0.2, at 0.372 s)",
            "stop",
        ),
    ],
)
def test_failed_checks_are_described_in_words(check: Check, described: str, named: str) -> None:
    certificate = Certificate(False, 0.1, 0.1, ("", ""), 0.0, (check,))
    assert not_certified(certificate, ["it"], None).detail.endswith(
        f"; the last failed {described}"
    )
    assert failed_checks(certificate) == named
