"""Malformed requests fail the form check, without an error."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydrake.geometry import Sphere
from pydrake.math import RigidTransform

from planning.certify.certifier import CertifyRequest, certify
from planning.world.collision.margins import PairMargins
from tests.certify.chains import FLOATING, Builder, P, Robot
from tests.certify.conftest import quintic
from tests.clocks import no_hurry

pytestmark = [pytest.mark.usefixtures("implementation"), pytest.mark.drake_only]

NAN, INF = float("nan"), float("inf")


def question() -> tuple[Robot, CertifyRequest]:
    builder = Builder()
    builder.link(FLOATING, Sphere(0.05))
    builder.link(P, Sphere(0.05), 0)
    builder.obstacle("thing", Sphere(0.1), RigidTransform(np.array([3.0, 0.0, 0.0])))
    robot = builder.build()
    q0 = np.array([1.0, 0, 0, 0, 0, 0, 0, 0])
    q1 = np.array([0.6, 0.8, 0, 0, 0.1, 0.2, 0.3, 0.4])
    return robot, robot.request(quintic(robot.group, q0, q1, 1.0), PairMargins(0.0))


def with_entry(array: np.ndarray, value: float) -> np.ndarray:
    changed = np.array(array)
    changed.flat[0] = value
    return changed


def of_trajectory(**arrays: Any) -> Any:
    return lambda r: replace(
        r,
        trajectory=replace(
            r.trajectory, **{k: change(getattr(r.trajectory, k)) for k, change in arrays.items()}
        ),
    )


def of_request(**arrays: Any) -> Any:
    return lambda r: replace(r, **{k: change(getattr(r, k)) for k, change in arrays.items()})


def of_limits(**arrays: Any) -> Any:
    return lambda r: replace(
        r,
        limits=replace(
            r.limits, **{k: change(getattr(r.limits, k)) for k, change in arrays.items()}
        ),
    )


FAULTS = {
    "nan in bases": of_trajectory(bases=lambda a: with_entry(a, NAN)),
    "nan in coefficients": of_trajectory(coefficients=lambda a: with_entry(a, NAN)),
    "inf in coefficients": of_trajectory(coefficients=lambda a: with_entry(a, INF)),
    "huge coefficients": of_trajectory(coefficients=lambda a: np.array(a) * 1e300),
    "nan in breaks": of_trajectory(breaks=lambda a: a * NAN),
    "no duration": of_trajectory(breaks=lambda a: a * 0),
    "not from 0": of_trajectory(breaks=lambda a: a + 1.0),
    "a quaternion of zeros": of_trajectory(bases=lambda a: a * [0, 0, 0, 0, 1, 1, 1, 1]),
    "a long quaternion": of_trajectory(bases=lambda a: a * [1.1, 1, 1, 1, 1, 1, 1, 1]),
    "a column too few": of_trajectory(coefficients=lambda a: a[:, :, :-1]),
    "no coefficient": of_trajectory(coefficients=lambda a: a[:, :0]),
    "nan in start": of_request(start=lambda a: a * NAN),
    "nan in state": of_request(state=lambda a: a * NAN),
    "nan among goals": of_request(goals=lambda a: np.concatenate([a, a * NAN])),
    "no goal": of_request(goals=lambda a: a[:0]),
    "a nan limit": of_limits(upper=lambda a: a * NAN),
    "a nan rate": of_limits(velocity=lambda a: a * NAN),
    "a rate of zero": of_limits(acceleration=lambda a: a * 0),
    "a rate too few": of_limits(velocity=lambda a: a[:1]),
    "other joints": lambda r: replace(
        r, trajectory=replace(r.trajectory, joints=r.trajectory.joints[::-1])
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_of_form_are_a_failed_check(name: str) -> None:
    robot, request = question()
    if name == "a rate too few":
        # Built without the shape checks of the constructor.
        limits = object.__new__(type(request.limits))
        limits.__dict__.update(request.limits.__dict__, velocity=request.limits.velocity[:1])
        faulty = replace(request, limits=limits)
    else:
        faulty = FAULTS[name](request)
    certificate, report = certify(robot.model, faulty, no_hurry(9.0))
    assert not certificate.proven
    (check,) = certificate.checks
    assert (check.name, check.passed) == ("form", False)
    assert check.where
    assert report.distance_queries == 0


def test_a_sound_request_has_no_fault() -> None:
    robot, request = question()
    certificate, _ = certify(robot.model, request, no_hurry(9.0))
    assert certificate.proven
