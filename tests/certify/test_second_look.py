"""What the kernel's bounds do not decide, Drake's distances do, before a motion is refused."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydrake.geometry import Box, Sphere

from planning.certify import clearance
from planning.certify.certifier import certify
from planning.certify.native_clearance import native_clearance
from planning.certify.proof_parts import Clearance
from planning.kernel.native import native
from planning.world.margins import PairMargins
from tests.certify.conftest import quintic
from tests.certify.test_clearance import slider
from tests.clocks import no_hurry

pytestmark = pytest.mark.skipif(native() is None, reason="the native code is not built")


def undecided(*asked: Any) -> Clearance:
    """Do as the kernel does where its bounds are no good: refuse, of no pair that is too near."""
    found = native_clearance(*asked)
    return replace(found, check=replace(found.check, passed=False), is_decided=False)


@pytest.mark.parametrize(("end", "passes"), [(0.3, True), (0.5, False)])
def test_drake_decides_what_the_kernel_does_not(
    monkeypatch: pytest.MonkeyPatch, end: float, passes: bool
) -> None:
    robot = slider(Sphere(0.05), Box(1.0, 1.0, 0.1), np.array([0.0, 0.0, 0.5]))
    motion = quintic(robot.group, np.zeros(1), np.array([end]), 1.0)
    request = robot.request(motion, PairMargins(0.0))
    alone = certify(robot.model, request, no_hurry(30.0))
    monkeypatch.setattr(clearance, "native_clearance", undecided)
    certificate, report = certify(robot.model, request, no_hurry(30.0))
    check = next(check for check in certificate.checks if check.name == "clearance")
    assert check.passed == passes
    assert report.distance_queries > alone[1].distance_queries
    if passes:
        assert certificate.min_clearance == pytest.approx(0.1, abs=2e-3)
        assert check.resolution <= 2e-3


def test_what_is_decided_asks_nobody_else(monkeypatch: pytest.MonkeyPatch) -> None:
    def unasked(*_: Any) -> Clearance:
        raise AssertionError

    monkeypatch.setattr(clearance, "DrakeProof", unasked)
    robot = slider(Sphere(0.05), Box(1.0, 1.0, 0.1), np.array([0.0, 0.0, 0.5]))
    for end, passes in ((0.3, True), (0.5, False)):
        motion = quintic(robot.group, np.zeros(1), np.array([end]), 1.0)
        request = robot.request(motion, PairMargins(0.0))
        found = clearance.check_clearance(robot.model, request, no_hurry(30.0))
        assert found.check.passed == passes
