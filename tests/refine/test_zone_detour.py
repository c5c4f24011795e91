"""Around speed zones where that is quicker, through them where it is not."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.geometry.pose import Pose
from planning.domain.request.constraint import PlacedBox
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import MotionLimits, SpeedZone
from planning.domain.request.options import RefineOptions, RetimeOptions
from planning.refine.curves.bspline_basis import basis_weights
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.refine.zone_detour import ZoneDetour
from planning.retime.limits.request_limits import path_limits
from planning.retime.retimer import retime
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

STRAIGHT = np.array([[-0.6, 0.0], [0.6, 0.0]])


def zone_at(place: list[float], size: list[float], speed: float, turn: float = 0.0) -> SpeedZone:
    pose = Pose.from_parts([*place, 0.0], rpy=[0.0, 0.0, turn])
    return SpeedZone("slow", "puck::puck", PlacedBox(np.array([*size, 1.0]), pose), speed)


def request_of(world: World, *zones: SpeedZone) -> RefineRequest:
    path = JointPath(world.group("puck"), STRAIGHT)
    others = MotionLimits(speed_zones=zones)
    limits = world.limits(path.group)
    return RefineRequest(path, limits, world.margins(), RefineOptions(), motion_limits=others)


def within() -> Deadline:
    return no_hurry(60.0)


def timed(world: World, request: RefineRequest, curve: JointSpline) -> float:
    """Return how long a curve takes [s]."""
    options = RetimeOptions(speed_zones=request.motion_limits.speed_zones)
    limits = path_limits(world, request.path.group, options)
    return retime(curve, request.limits, options, limits)[0].duration


def test_a_detour_is_found_from_the_middle_of_a_zone(make_puck: Callable[..., World]):
    """The straight path is in the middle: no gradient leads out on either side."""
    world = make_puck([])
    zone = zone_at([0.0, 0.0], [0.4, 0.3], 0.1)
    request = request_of(world, zone)
    curve, report = refine(world, request, within())
    assert curve is not None, report.reason
    at = curve.positions(np.linspace(0.0, 1.0, 2001))
    assert not (np.abs(at) < [0.2, 0.15]).all(axis=1).any()
    refined = timed(world, request, curve)
    assert report.duration_after == pytest.approx(refined, rel=0.02)
    # As quick as it gets: both ways there and back are ways of a joint.
    assert refined < 1.1 * report.lower_bound < 0.5 * timed(world, request, request.path.spline)


def test_if_the_detour_takes_longer_the_curve_goes_through(make_puck: Callable[..., World]):
    world = make_puck([])
    request = request_of(world, zone_at([0.0, 0.0], [0.02, 1.6], 0.4))
    curve, report = refine(world, request, within())
    assert curve is not None, report.reason
    assert timed(world, request, curve) <= 1.03 * timed(world, request, request.path.spline)


def test_without_a_detour_the_path_in_the_zone_is_the_shortest(
    make_puck: Callable[..., World],
):
    """A slab without ends that lies askew: straight across it is quicker than straight ahead."""
    world = make_puck([])
    request = request_of(world, zone_at([0.0, 0.0], [0.3, np.inf], 0.1, 0.6))
    curve, report = refine(world, request, within())
    assert curve is not None, report.reason
    refined = timed(world, request, curve)
    assert report.duration_after == pytest.approx(refined, rel=0.02)
    assert 3.0 < refined < 0.95 * timed(world, request, request.path.spline)


@given(
    place=st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)),
    size=st.tuples(st.floats(0.1, 0.5), st.floats(0.1, 0.5)),
    turn=st.floats(-1.5, 1.5),
)
@settings(max_examples=num_cases(6), suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_guesses_are_lifted_out_of_zones(
    make_puck: Callable[..., World],
    place: tuple[float, float],
    size: tuple[float, float],
    turn: float,
):
    world = make_puck([])
    request = request_of(world, zone_at(list(place), list(size), 0.1, turn))
    detour = ZoneDetour.of(world, request, within())
    assert detour is not None
    (box,) = detour.boxes
    guess = detour.problem.fit_path(0.15)
    sample = basis_weights(len(guess), np.linspace(0.0, 1.0, 201))
    depth = -box.signed_margins(sample.apply(guess)).min()
    lifted = list(detour.guesses(guess))
    assert bool(lifted) is bool(depth > 0)
    for points in lifted:
        np.testing.assert_allclose(points[[0, -1]], STRAIGHT, atol=1e-12)
        beyond = -box.signed_margins(
            basis_weights(len(points), np.linspace(0.0, 1.0, 201)).apply(points)
        ).min()
        assert beyond < max(0.02, 0.7 * depth)


def test_zones_that_hold_an_end_are_not_avoided(make_puck: Callable[..., World]):
    world = make_puck([])
    about, between = zone_at([0.6, 0.0], [0.2, 0.2], 0.1), zone_at([0.0, 0.0], [0.2, 0.2], 0.1)
    between = replace(between, name="between")
    assert ZoneDetour.of(world, request_of(world), within()) is None
    assert ZoneDetour.of(world, request_of(world, about), within()) is None
    detour = ZoneDetour.of(world, request_of(world, about, between), within())
    assert detour is not None
    assert [box.label for box in detour.boxes] == ["between"]
    assert detour.problem.request.motion_limits.speed_zones == (about,)


def test_a_floating_body_takes_a_detour_too():
    world = bundled_world("window_3d")
    group = world.group("body")
    start = world.positions(group)
    ahead = np.array(start)
    ahead[5] -= 0.4
    path = JointPath(group, np.stack([start, ahead]))
    place = Pose.from_parts((start + ahead)[4:] / 2)
    zone = SpeedZone("slow", "body::body", PlacedBox(np.full(3, 0.15), place), 0.05)
    others = MotionLimits(speed_zones=(zone,))
    request = RefineRequest(
        path, world.limits(group), world.margins(), RefineOptions(), motion_limits=others
    )
    curve, report = refine(world, request, within())
    assert curve is not None, report.reason
    assert timed(world, request, curve) < 0.6 * timed(world, request, path.spline)
