"""Given paths and trajectories: constraints on them, and the deviation of rounded corners."""

from functools import cache
from typing import Any

import numpy as np
import pytest

import planning
from planning.api.retime_path import RetimedPath
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import CertifyOptions, RetimeOptions
from planning.errors import NotCertified, ProblemInvalid, UnknownName
from planning.world.world import World
from tests.clocks import after_looks, no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases, rng_of, seeds

LOCKED = (planning.LockedJoints(("arm::elbow_joint",)),)


def soon() -> Deadline:
    return no_hurry(30.0)


def retimed(world: World, path: np.ndarray, **asked: Any) -> RetimedPath:
    return planning.retime_path(world, "arm", path, deadline=soon(), **asked)


def through(world: World, *shifts: list[float]) -> np.ndarray:
    home = world.positions(world.group("arm"))
    return np.stack([home, *(home + np.array(shift) for shift in shifts)])


def away_from(path: np.ndarray, q: np.ndarray) -> float:
    """Return the distance of a configuration from a polyline."""
    a, step = path[:-1], np.diff(path, axis=0)
    along = np.clip(((q - a) * step).sum(axis=1) / (step**2).sum(axis=1), 0.0, 1.0)
    return float(np.linalg.norm(a + along[:, None] * step - q, axis=1).min())


def test_a_path_keeps_constraints_or_is_refused_with_their_names(pickup: World) -> None:
    still = through(pickup, [-0.3, -0.1, 0, 0, 0, 0], [-0.5, -0.2, 0, 0.1, 0, 0.1])
    found = retimed(pickup, still, constraints=LOCKED)
    (kept,) = (check for check in found.certificate.checks if "locked" in check.name)
    assert kept.passed
    moved = through(pickup, [-0.3, -0.1, 0.05, 0, 0, 0], [-0.5, -0.2, 0, 0.1, 0, 0.1])
    assert retimed(pickup, moved).certificate.proven
    with pytest.raises(NotCertified) as caught:
        retimed(pickup, moved, constraints=LOCKED)
    assert kept.name in {check["name"] for check in caught.value.evidence["checks"]}


def test_a_trajectory_is_held_against_constraints(pickup: World) -> None:
    moved = retimed(pickup, through(pickup, [-0.3, -0.1, 0.05, 0, 0, 0])).trajectory
    certificate, _ = planning.certify_trajectory(
        pickup, "arm", moved, deadline=soon(), constraints=LOCKED
    )
    assert not certificate.proven
    assert [check.name for check in certificate.failed] == ["constraint 0: locked_joints"]


def test_constraints_that_make_no_sense_are_named(pickup: World) -> None:
    nobody = (planning.LockedJoints(("arm::knee_joint",)),)
    with pytest.raises(UnknownName, match="knee_joint"):
        retimed(pickup, through(pickup, [0.1] * 6), constraints=nobody)


def test_a_path_of_ones_own_can_be_asked_for_its_longest_stop(pickup: World) -> None:
    path = through(pickup, [-0.3, 0.1, 0, 0, 0, 0])
    assert retimed(pickup, path).certify.stop is None
    found = retimed(pickup, path, certify_options=CertifyOptions(stop_anywhere=True))
    assert found.certify.stop is not None


@cache
def cornered(method: Any, deviation: float) -> tuple[np.ndarray, RetimedPath]:
    """Return a path with two corners, and the motion along it."""
    world = bundled_world("ur5e_pickup")
    path = through(
        world, [-0.4, 0, 0, 0, 0, 0], [-0.4, 0.2, -0.3, 0, 0, 0], [-0.8, 0.2, 0, 0, 0, 0]
    )
    return path, retimed(world, path, options=RetimeOptions(method, deviation=deviation))


@pytest.mark.campaign
@pytest.mark.parametrize("deviation", [0.05, 0.3, 0.02, 0.004, 0.0][: num_cases(2, 5)])
@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_corners_are_rounded_no_farther_than_asked_for(deviation: float, method: Any) -> None:
    path, found = cornered(method, deviation)
    instants = np.linspace(0.0, found.trajectory.duration, 400)
    away = max(away_from(path, q) for q in found.trajectory.positions(instants))
    assert found.retime.blend_deviation <= deviation
    assert away <= deviation + 1e-9
    _, exact = cornered(method, 0.0)
    assert found.trajectory.duration <= exact.trajectory.duration + 1e-9
    if deviation >= 0.02:
        # Farther than this no corner need be rounded to be followed without a rest.
        assert away > 0.5 * min(deviation, 0.05)
        assert found.trajectory.duration < 0.95 * exact.trajectory.duration


@pytest.mark.parametrize("deviation", [-0.1, np.inf, np.nan])
def test_a_deviation_that_is_no_length_is_refused(pickup: World, deviation: float) -> None:
    with pytest.raises(ProblemInvalid, match="deviation"):
        retimed(pickup, through(pickup, [0.1] * 6), options=RetimeOptions(deviation=deviation))


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
@pytest.mark.parametrize("field", ["velocity_scale", "acceleration_scale"])
@pytest.mark.parametrize("scale", [1e-300, 1e-160, 0.0, 1.1, np.nan])
def test_a_scale_that_leaves_nothing_is_refused(
    pickup: World, field: str, scale: float, method: Any
) -> None:
    options = RetimeOptions(method, **{field: scale})
    with pytest.raises(ProblemInvalid, match=rf"retime.{field}: it must be in \[1e-09, 1\]"):
        retimed(pickup, through(pickup, [0.1] * 6), options=options)


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_a_waypoint_that_no_joint_reaches_is_refused_at_once(pickup: World, method: Any) -> None:
    path = through(pickup, [-0.3, 0, 0, 0, 0, 0], [1e6, 0, 0, 0, 0, 0])
    with pytest.raises(ProblemInvalid, match=r"waypoints.2: arm::shoulder_pan_joint = 1e\+06 is"):
        planning.retime_path(
            pickup, "arm", path, deadline=after_looks(1), options=RetimeOptions(method)
        )
    limits = pickup.limits(pickup.group("arm"))
    on_the_limit = through(pickup, [-0.3, 0, 0, 0, 0, 0])
    on_the_limit[1, 5] = limits.upper[5] + 5e-7  # a rounding error
    assert retimed(pickup, on_the_limit).certificate.proven


@pytest.mark.parametrize("seed", seeds(6))
def test_a_refusal_has_the_configuration_at_which_each_check_fails(
    pickup: World, seed: int
) -> None:
    group = pickup.group("arm")
    path = through(pickup, rng_of(seed).uniform(-1.0, 1.0, 6).tolist())
    margin = 0.5  # more than any arm keeps from its table
    with pytest.raises(NotCertified) as caught:
        retimed(pickup, path, margin=margin)
    (check,) = (c for c in caught.value.evidence["checks"] if c["name"] == "clearance")
    q = np.array(check["positions"])
    assert away_from(path, q) < 1e-9
    (there,) = planning.check_configurations(pickup, group.name, q[None], margin)
    named = {"-".join(pair.bodies): pair.distance for pair in there.violations}
    assert named[check["where"]] == pytest.approx(check["value"], abs=1e-6)
