"""Delivered motions: sampled anew, as JSON or as a table, drawn, and replayed in 3-D."""

import csv
import io
import time
from base64 import b64encode
from dataclasses import replace

from planning import Deadline, TimedTrajectory
from planning.api.motion_series import MotionSeries, motion_series
from planning.api.sample_motion import sample_plan, unproven_samples
from planning.errors import InputError
from planning.world.replay.replay_writer import replay_html
from planning.world.replay.scene_motion import scene_motion
from service.api.arrays import matrix
from service.jobs.context import TaskContext
from service.plans.exports.exported_motion import ExportedMotion
from service.plans.exports.formats import FORMATS, require_format
from service.plans.exports.series import Series
from service.plans.models.sampling import IN_QUERY, require_few
from service.plans.models.trajectory import Polynomial, Trajectory
from service.plans.tasks import (
    EXPORT,
    PLOT,
    PLOT_ALL,
    REPLAY,
    SAMPLE,
    SAMPLE_TABLE,
    SERIES,
    DeliveredWork,
    Drawing,
    Drawings,
    ExportedFile,
    ExportWork,
    Page,
    PlotWork,
    SampleWork,
    SeriesWork,
    Table,
)
from service.plans.worker import PROVING
from service.scenes.world_cache import borrow_world

# A chart of a motion among few bodies takes a tenth of a second [s].
_ALLOWED_FOR_CHART = 20.0


@SAMPLE.runs
def sample(work: SampleWork, context: TaskContext) -> Trajectory:
    """Sample a motion at its new speed, and prove the samples.

    Raises:
        ProblemInvalid: That would be too many samples.
    """
    slowed = work.trajectory.to_domain().time_scaled(1 / work.scale)
    samples = _proven(work, slowed, context)
    if not work.polynomial:
        return samples
    return samples.model_copy(update={"polynomial": Polynomial.from_domain(slowed)})


@SAMPLE_TABLE.runs
def sample_as_table(work: SampleWork, context: TaskContext) -> Table:
    """Sample as `sample` does; give time, positions, velocities, accelerations in rows.

    Raises:
        ProblemInvalid: That would be too many samples.
    """
    samples = sample(work, context)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([
        "time",
        *(f"position:{name}" for name in samples.joint_names),
        *(f"velocity:{name}" for name in samples.velocity_names),
        *(f"acceleration:{name}" for name in samples.velocity_names),
    ])
    columns = (samples.positions, samples.velocities, samples.accelerations)
    for instant, q, v, vdot in zip(samples.times, *columns, strict=True):
        writer.writerow([instant, *q, *v, *vdot])
    return Table(text=text.getvalue(), proven=_verdicts(samples))


@EXPORT.runs
def export(work: ExportWork, context: TaskContext) -> ExportedFile:
    """Sample as `sample` does; give the samples as a file of another program.

    Raises:
        ProblemInvalid: That would be too many samples, or the format cannot hold them.
        InputError: The format shows the scene, which does not load any more.
    """
    require_format(work.format, work.trajectory.joint_types)
    samples = sample(work, context)
    form, scene = FORMATS[work.format], None
    if form.shows_scene:
        with borrow_world(work) as world:
            scene = scene_motion(world, world.group(work.group), matrix(samples.positions))
    content = form.write(ExportedMotion(samples, scene))
    return ExportedFile(base64=b64encode(content).decode(), proven=_verdicts(samples))


def _verdicts(samples: Trajectory) -> str:
    """Return what is proven of samples, for a header."""
    return ", ".join(
        f"{proof.kind}={'proven' if proof.proven else 'unproven'}"
        for proof in samples.interpolations
    )


def _proven(work: SampleWork, trajectory: TimedTrajectory, context: TaskContext) -> Trajectory:
    """Return samples and what is proven of them: nothing, if the scene does not load any more."""
    require_few(trajectory, work.sampling, IN_QUERY)
    slowed = [
        replace(part, begin=part.begin / work.scale, end=part.end / work.scale)
        for part in work.parts
    ]
    deadline = Deadline.after(PROVING, time.monotonic, context.is_canceled)
    try:
        problem = work.request.to_domain()
        with borrow_world(work) as world:
            proven = sample_plan(
                world,
                problem,
                trajectory,
                slowed,
                work.sampling,
                deadline=deadline,
                clearance=work.clearance,
            )
    except InputError as fault:
        proven = unproven_samples(trajectory, work.sampling, fault.detail)
    return Trajectory.from_samples(proven.samples, proven.interpolations)


@PLOT.runs
def plot(work: PlotWork, context: TaskContext) -> Drawing:
    """Draw a chart of a motion.

    Raises:
        InputError: The scene does not load any more.
        DeadlineExceeded: Its distances take too long.
    """
    (svg,) = _drawn(work, context).values()
    return Drawing(svg=svg)


@PLOT_ALL.runs
def plot_all(work: PlotWork, context: TaskContext) -> Drawings:
    """Draw several charts of a motion; raises as `plot`."""
    return Drawings(svg=_drawn(work, context))


def _drawn(work: PlotWork, context: TaskContext) -> dict[str, str]:
    from service.plans.delivery.charts import OF_DISTANCES, draw  # noqa: PLC0415  (takes a second)

    found = _series(work, context, distances=not OF_DISTANCES.isdisjoint(work.names))
    return {name: draw(name, found) for name in work.names}


@SERIES.runs
def series(work: SeriesWork, context: TaskContext) -> Series:
    """Return the numbers of the plots of a motion.

    Raises:
        InputError: The scene does not load any more.
        DeadlineExceeded: Its distances take too long.
    """
    found = _series(work, context, num_samples=work.num_samples, distances=work.distances)
    return Series.from_series(found, distances=work.distances)


def _series(
    work: PlotWork | SeriesWork, context: TaskContext, *, num_samples: int = 201, distances: bool
) -> MotionSeries:
    with borrow_world(work) as world:
        return motion_series(
            world,
            work.group,
            work.trajectory.to_domain(),
            num_samples,
            options=work.retime.to_domain(),
            margin=work.margin,
            distances=distances,
            deadline=Deadline.after(_ALLOWED_FOR_CHART, time.monotonic, context.is_canceled),
        )


@REPLAY.runs
def replay(work: DeliveredWork, _: TaskContext) -> Page:
    """Make the page that replays a motion in 3-D.

    Raises:
        InputError: The scene does not load any more.
    """
    trajectory = work.trajectory.to_domain()
    with borrow_world(work) as world:
        return Page(html=replay_html(world, world.group(work.group), trajectory))
