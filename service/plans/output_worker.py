"""Delivered trajectories, sampled anew, as JSON or CSV, and as something to look at."""

import csv
import io
import math
import time
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

from planning import Deadline, TimedTrajectory, World
from planning.api.sample_motion import sample_plan, unproven_samples
from planning.domain.curves.sampling import Sampling
from planning.domain.report.motion_plan import PlanPart
from planning.errors import InputError
from planning.world.replay.replay_writer import ShownMotion, replay_html, replay_motions_html
from service.jobs.context import TaskContext
from service.plans.models.goal_values import problem_value
from service.plans.models.request import PlanRequest
from service.plans.models.trajectory_conversion import (
    IN_QUERY,
    polynomial_wire,
    require_few,
    sampled_wire,
    trajectory_value,
)
from service.plans.worker import PROVING
from service.scenes.tasks import SceneWork
from service.scenes.world_cache import borrow_world


def sample(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return a trajectory slowed to `scale` of its speed, sampled as `sampling` says.

    Raises:
        ProblemInvalid: That would be too many samples.
    """
    trajectory = trajectory_value(payload["trajectory"]).time_scaled(1 / payload["scale"])
    exact = polynomial_wire(trajectory) if payload["polynomial"] else None
    return {**_proven(payload, trajectory, channel), "polynomial": exact}


def sample_csv(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return `text`, and `proven`: what is proven of it, in a line.

    The text is a header, then a row per instant: time, positions, velocities, accelerations.

    Raises:
        ProblemInvalid: That would be too many samples.
    """
    sampled = sample({**payload, "polynomial": False}, channel)
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
    for time_, q, v, vdot in zip(sampled["times"], *columns, strict=True):
        writer.writerow([time_, *q, *v, *vdot])
    verdicts = ((proof["kind"], proof["proven"]) for proof in sampled["interpolations"])
    told = ", ".join(f"{kind}={'proven' if proven else 'unproven'}" for kind, proven in verdicts)
    return {"text": text.getvalue(), "proven": told}


def _proven(
    payload: dict[str, Any], trajectory: TimedTrajectory, channel: TaskContext
) -> dict[str, Any]:
    """Return samples and what is proven of them: nothing, if the scene does not load any more."""
    sampling, scale = Sampling(**payload["sampling"]), payload["scale"]
    require_few(trajectory, sampling, IN_QUERY)
    parts = [PlanPart(**part) for part in payload["parts"]]
    slowed = [replace(part, begin=part.begin / scale, end=part.end / scale) for part in parts]
    deadline = Deadline.after(PROVING, time.monotonic, channel.is_canceled)
    try:
        problem = problem_value(PlanRequest.model_validate(payload["request"]))
        with borrow_world(SceneWork.model_validate(payload)) as world:
            proven = sample_plan(
                world,
                problem,
                trajectory,
                slowed,
                sampling,
                deadline=deadline,
                clearance=_clearance(payload["certificate"]),
            )
    except InputError as fault:
        proven = unproven_samples(trajectory, sampling, fault.detail)
    return sampled_wire(proven.samples, proven.interpolations)


def _clearance(certificate: dict[str, Any]) -> float:
    """Return what the certificate of a plan says that no distance is below [m].

    Plans of older versions have the smallest distance that was seen instead, and are told anew.
    """
    if "observed_clearance" not in certificate:
        return -math.inf
    nearest = certificate["min_clearance"]
    return math.inf if nearest is None else nearest


def replay(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """Return `html`: a page that replays the motion in 3-D and needs nothing else.

    Raises:
        InputError: The scene does not load any more.
    """
    trajectory = trajectory_value(payload["trajectory"])
    with borrow_world(SceneWork.model_validate(payload)) as world:
        return {"html": replay_html(world, world.group(payload["group"]), trajectory)}


def replay_scene(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """Return `html`: a page that replays `motions` in 3-D, each in a scene of its own.

    Raises:
        InputError: A scene does not load any more.
    """
    worlds: dict[str, World] = {}
    shown: list[ShownMotion] = []
    with ExitStack() as borrowed:
        for motion in payload["motions"]:
            digest = motion["scene"]["digest"]
            if digest not in worlds:
                worlds[digest] = borrowed.enter_context(
                    borrow_world(SceneWork.model_validate(motion))
                )
            world, trajectory = worlds[digest], trajectory_value(motion["trajectory"])
            group = world.group(motion["group"])
            shown.append(ShownMotion(motion["title"], world, group, trajectory, motion["until"]))
        return {"html": replay_motions_html(shown)}
