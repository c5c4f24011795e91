"""Motion series: consistent with the certificate and with the requested limits."""

import numpy as np
import pytest

import planning
from planning.api.motion_series import motion_series
from planning.domain.request.motion_limits import ToolLimit
from planning.domain.request.options import RetimeOptions
from planning.world.world import World
from tests.clocks import no_hurry

BOUNDS = {"arm::elbow_joint": (-0.2, 0.3)}
TOOL = "arm::tcp"


# Distances at an instant take longer than everything else.
COUNT = 101


def made_with(
    world: World, options: RetimeOptions, margin: float | None = None, *, distances: bool = False
):
    home = world.positions(world.group("arm"))
    path = home + np.array([np.zeros(6), [0.4, 0.1, -0.2, 0, 0.1, 0], [0.8, -0.1, 0.1, 0.3, 0, 0]])
    deadline = no_hurry(20.0)
    made = planning.retime_path(
        world, "arm", path, deadline=deadline, options=options, margin=margin
    )
    series = motion_series(
        world, "arm", made.trajectory, COUNT, options, margin, distances=distances
    )
    return made, series


@pytest.mark.parametrize(
    ("method", "velocity", "acceleration"),
    [("toppra", 0.5, 0.25), ("toppra", 0.1, 1.0), ("ruckig", 0.3, 0.6)],
)
def test_use_of_scaled_limits_is_that_of_the_certificate(
    pickup: World, method: str, velocity: float, acceleration: float
) -> None:
    options = RetimeOptions(method=method, velocity_scale=velocity, acceleration_scale=acceleration)
    made, series = made_with(pickup, options)
    used = series.utilisation
    peaks = {c.name: c.value for c in made.certificate.checks if c.name in {*used} - {"torque"}}
    assert set(peaks) == {"velocity", "acceleration"} | ({"jerk"} & set(used))
    for name, peak in peaks.items():
        # Short pieces at a limit may lie between samples.
        assert 0.8 * peak < used[name].max() <= peak + 1e-6, name
    assert max(peaks.values()) == pytest.approx(1.0, abs=1e-3)
    whole = pickup.limits(series.group)
    np.testing.assert_allclose(series.limits.velocity, velocity * whole.velocity)
    np.testing.assert_allclose(series.limits.acceleration, acceleration * whole.acceleration)


def test_jerk_counts_only_where_it_is_limited_and_jumps_are_told(pickup: World) -> None:
    _, plain = made_with(pickup, RetimeOptions())
    _, smooth = made_with(pickup, RetimeOptions(method="ruckig"))
    assert "jerk" not in plain.utilisation
    assert len(plain.acceleration_jumps)
    assert smooth.utilisation["jerk"].max() > 0.5
    assert not len(smooth.acceleration_jumps)


def test_the_acceleration_range_has_bounds_by_sign(pickup: World) -> None:
    options = RetimeOptions(acceleration_scale=0.5, acceleration_bounds=BOUNDS)
    _, series = made_with(pickup, options)
    lowest, highest = series.acceleration_range
    elbow = series.group.velocity_names.index("arm::elbow_joint")
    assert (lowest[elbow], highest[elbow]) == BOUNDS["arm::elbow_joint"]
    others = np.arange(6) != elbow
    np.testing.assert_allclose(highest[others], series.limits.acceleration[others])
    assert (series.derivatives[1] >= lowest - 1e-6).all()
    assert (series.derivatives[1] <= highest + 1e-6).all()


@pytest.mark.parametrize("margin", [0.0, 0.02, 0.08])
def test_what_is_to_spare_is_over_the_margin_asked_for(pickup: World, margin: float) -> None:
    made, series = made_with(pickup, RetimeOptions(), margin, distances=True)
    check = next(c for c in made.certificate.checks if c.name == "clearance")
    assert series.margin == margin
    assert series.signed_margin.min() == pytest.approx(check.value - check.bound, abs=2e-3)
    assert series.clearance.min() == pytest.approx(made.certificate.min_clearance, abs=2e-3)


def test_tool_speeds_are_those_of_the_frames_ways(pickup: World) -> None:
    options = RetimeOptions(tool_limits=(ToolLimit("arm::forearm_link", 0.1),))
    made, series = made_with(pickup, options)
    assert set(series.tool_speeds) == {TOOL, "arm::forearm_link"}
    step, group = 1e-5, series.group
    at = series.times[1:-1]
    for frame, speeds in series.tool_speeds.items():
        before, after = (
            pickup.frame_poses(frame, pickup.embed(group, made.trajectory.positions(t)))[:, :3, 3]
            for t in (at - step, at + step)
        )
        ways = np.linalg.norm(after - before, axis=1) / (2 * step)
        np.testing.assert_allclose(speeds[1:-1], ways, atol=1e-4)
    assert series.tool_speeds["arm::forearm_link"].max() == pytest.approx(0.1, rel=0.01)


def test_all_but_distances_is_the_same_without_them(pickup: World) -> None:
    made, _ = made_with(pickup, RetimeOptions())
    both = [
        motion_series(pickup, "arm", made.trajectory, 5, distances=distances)
        for distances in (True, False)
    ]
    for name in (
        "times",
        "positions",
        "derivatives",
        "efforts",
        "acceleration_jumps",
        "margin",
        "path_limit_utilisation",
    ):
        np.testing.assert_equal(*(getattr(series, name) for series in both), err_msg=name)
    measured, bare = both
    assert np.isfinite([measured.clearance, measured.signed_margin]).all()
    assert np.isnan([bare.clearance, bare.signed_margin]).all()
    assert bare.closest_pairs == (("", ""),) * 5
