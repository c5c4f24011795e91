"""Charts of a motion: that limits are drawn where they were asked for."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

import planning
from planning.api.motion_series import MotionSeries, motion_series
from planning.domain.request.options import RetimeOptions
from planning.world.world import World
from service.plans.delivery.charts import CHARTS
from tests.clocks import no_hurry

BOUNDS = {"arm::shoulder_pan_joint": (-0.9, 0.6)}


@pytest.fixture(scope="module")
def series(pickup: World) -> MotionSeries:
    home = pickup.positions(pickup.group("arm"))
    options = RetimeOptions(velocity_scale=0.2, acceleration_bounds=BOUNDS)
    made = planning.retime_path(
        pickup,
        "arm",
        home + np.array([np.zeros(6), [0.6, 0.1, 0, 0, 0, 0.1]]),
        deadline=no_hurry(20.0),
        options=options,
        margin=0.02,
    )
    return motion_series(pickup, "arm", made.trajectory, 51, options=options, margin=0.02)


def figure_of(name: str, series: MotionSeries) -> Figure:
    figure = Figure()
    CHARTS[name](figure, series)
    return figure


def words(name: str, series: MotionSeries) -> str:
    return " ".join(text.get_text() for text in figure_of(name, series).findobj(Text))


def levels(name: str, series: MotionSeries) -> list[set[float]]:
    """Return the heights of the limits' lines, by row."""
    return [
        {float(line.get_ydata()[0]) for line in axes.lines if line.get_linestyle() in {"--", ":"}}
        for axes in figure_of(name, series).axes
    ]


def test_limits_are_drawn_where_they_were_asked_for(pickup: World, series: MotionSeries) -> None:
    whole = pickup.limits(series.group)
    velocity = [{-0.2 * limit, 0.2 * limit} for limit in whole.velocity]
    acceleration = [{-limit, limit} for limit in whole.acceleration]
    acceleration[0] = {*BOUNDS["arm::shoulder_pan_joint"]}
    for name, wanted in (("velocity", velocity), ("acceleration", acceleration)):
        drawn = levels(name, series)
        for row, limits in zip(drawn, wanted, strict=True):
            np.testing.assert_allclose(sorted(row), sorted(limits), err_msg=name)
    tool = planning.ToolLimit("arm::tcp", 0.5)
    limited = replace(series, options=replace(series.options, tool_limits=(tool,)))
    assert levels("tool_speed", limited) == [{0.5}]
    assert levels("tool_speed", series) == [set()]


def test_the_margin_is_drawn_if_one_is_demanded(series: MotionSeries) -> None:
    assert "margin, 20 mm" in words("clearance", series)
    assert levels("clearance", series) == [{0.0, 20.0}]
    bare = replace(series, margin=0.0, signed_margin=series.clearance)
    assert "margin" not in words("clearance", bare)


def test_jerk_without_limit_says_so(series: MotionSeries) -> None:
    assert "jerk is infinite" in words("jerk", series)
    assert "jerk was not limited" in words("utilisation", series)
    limited = replace(series, options=replace(series.options, method="ruckig"))
    assert "infinite" not in words("jerk", limited)
    assert "jerk was not" not in words("utilisation", limited)
