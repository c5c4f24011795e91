"""Delivered trajectories, sampled anew, as JSON or CSV, and as something to look at."""

import csv
import io
from typing import Any

from planning import replay_html
from planning.domain.curve import TimedTrajectory
from service.convert.trajectories import (
    IN_QUERY,
    polynomial_wire,
    sampled_wire,
    trajectory_value,
)
from service.tasks.channel import Channel
from service.tasks.worlds import borrow_world


def sample(payload: dict[str, Any], _: Channel) -> dict[str, Any]:
    """Return a trajectory slowed to `scale` of its speed, a sample every `period` [s].

    Or as many samples as `num_points` says, evenly in time.

    Raises:
        ProblemInvalid: That would be too many samples.
    """
    trajectory = _scaled(payload)
    sampled = sampled_wire(trajectory, payload["period"], payload["num_points"], IN_QUERY)
    exact = polynomial_wire(trajectory) if payload["polynomial"] else None
    return {**sampled, "polynomial": exact}


def sample_csv(payload: dict[str, Any], _: Channel) -> dict[str, Any]:
    """Return `text`: a header, then a row per instant: time, positions, velocities, accelerations.

    Raises:
        ProblemInvalid: That would be too many samples.
    """
    trajectory = _scaled(payload)
    sampled = sampled_wire(trajectory, payload["period"], payload["num_points"], IN_QUERY)
    header = [
        "time",
        *(f"position:{name}" for name in sampled["joint_names"]),
        *(f"velocity:{name}" for name in sampled["velocity_names"]),
        *(f"acceleration:{name}" for name in sampled["velocity_names"]),
    ]
    columns = (sampled["positions"], sampled["velocities"], sampled["accelerations"])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for time, q, v, vdot in zip(sampled["times"], *columns, strict=True):
        writer.writerow([time, *q, *v, *vdot])
    return {"text": text.getvalue()}


def replay(payload: dict[str, Any], _: Channel) -> dict[str, Any]:
    """Return `html`: a page that replays the motion in 3-D and needs nothing else.

    Raises:
        InputError: The scene does not load any more.
    """
    trajectory = trajectory_value(payload["trajectory"])
    with borrow_world(payload) as world:
        return {"html": replay_html(world, world.group(payload["group"]), trajectory)}


def _scaled(payload: dict[str, Any]) -> TimedTrajectory:
    return trajectory_value(payload["trajectory"]).slowed(1 / payload["scale"])
