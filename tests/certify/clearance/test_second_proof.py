"""Where the kernel's bounds are undecided, Drake's distances decide before a refusal."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydrake.geometry import Box, Sphere

from planning.certify.certifier import CertifyRequest
from planning.certify.clearance.clearance_check import check_clearance, quick_clearance
from planning.certify.clearance.clearance_result import ClearanceResult
from planning.kernel.native import native
from planning.world.collision.margins import PairMargins
from tests.certify.chains import Robot
from tests.certify.clearance.test_clearance_check import slider
from tests.certify.conftest import quintic
from tests.clocks import no_hurry

pytestmark = pytest.mark.skipif(native() is None, reason="the native code is not built")
ENDS = pytest.mark.parametrize(("end", "passes"), [(0.3, True), (0.5, False)])


def undecided(*arguments: Any) -> ClearanceResult:
    """Return the result of an undecided kernel: refused, without a violated margin."""
    found = quick_clearance(*arguments)
    return replace(found, check=replace(found.check, passed=False), is_decided=False)


def towards_a_wall(end: float) -> tuple[Robot, CertifyRequest]:
    """Return a ball that rises to a height, below a slab whose lower face is at 0.45."""
    robot = slider(Sphere(0.05), Box(1.0, 1.0, 0.1), np.array([0.0, 0.0, 0.5]))
    motion = quintic(robot.group, np.zeros(1), np.array([end]), 1.0)
    return robot, robot.request(motion, PairMargins(0.0))


@ENDS
def test_drake_decides_what_the_kernel_does_not(end: float, passes: bool) -> None:
    robot, request = towards_a_wall(end)
    alone = quick_clearance(robot.model, request, no_hurry())
    found = check_clearance(robot.model, request, no_hurry(), undecided)
    assert found.check.passed == passes
    assert found.num_queries > alone.num_queries
    assert found.num_segments > alone.num_segments
    if passes:
        assert found.nearest.distance == pytest.approx(0.1, abs=2e-3)
        assert found.check.resolution <= 2e-3


@ENDS
def test_a_decided_proof_is_not_repeated(end: float, passes: bool) -> None:
    robot, request = towards_a_wall(end)
    alone = quick_clearance(robot.model, request, no_hurry())
    assert alone.is_decided
    assert alone.check.passed == passes
    assert check_clearance(robot.model, request, no_hurry()) == alone
