"""Stop check: the longest stop along the path from any instant of a motion: duration, distance."""

import numpy as np
from jaxtyping import Float64

from planning.certify.frames.tool_rates import ToolRates
from planning.certify.intervals.motion_cells import MotionCells, motion_cells
from planning.certify.request import CertifyRequest
from planning.certify.stopping.stop_constraints import with_stop_constraints
from planning.certify.stopping.stops import Stops, hardest_stops, smooth_stops
from planning.domain.report.certificate import Check
from planning.domain.report.stop_report import StopReport
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Number of cells of a motion: fewer with jerk limits, where each takes more work.
_NUM_CELLS, _NUM_SMOOTH_CELLS = 600, 300


def stop_check(
    model: DrakeModel, request: CertifyRequest, deadline: Deadline
) -> tuple[Check, StopReport]:
    """Return the check and report of the longest stop along a proven trajectory; see `stops`.

    Proven positions and velocities hold for a stop: it has the same path, and no velocity is
    larger. Limits on accelerations of joints (also by sign) and of frames, on torques and on jerk
    are kept. Where the static load of a joint exceeds its limit no stop can end: stops continue to
    where the robot can rest, or to the end, and the report names the instant and the joint.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    deadline.check("certify")
    cells = motion_cells(request, _NUM_SMOOTH_CELLS if request.jerk else _NUM_CELLS)
    cells = with_stop_constraints(model, request, cells, deadline)
    stops = (smooth_stops if request.jerk else hardest_stops)(cells, deadline)
    # From within a cell the motion continues to the cell's end, and stops from there.
    times = cells.widths + stops.times[1:]
    longest = int(np.argmax(times))
    distances = _stopping_distances(model, request, cells, stops, deadline)
    report = StopReport(
        float(times[longest]), float(cells.begins[longest]), *distances, *_static_overload(cells)
    )
    max_stopping_time = request.options.max_stopping_time
    bound = np.inf if max_stopping_time is None else max_stopping_time
    passed = report.time <= bound
    where = report.unheld
    return Check("stop", report.time, bound, "s", 0.0, passed, where, report.begin), report


def _static_overload(cells: MotionCells) -> tuple[str, float | None]:
    """Return the block with the largest static overload and its instant [s]; or "" and None."""
    worst, overload = 1.0, ("", None)
    for constraint in cells.stop_constraints:
        utilizations = constraint.static_utilization
        cell, block = np.unravel_index(int(np.argmax(utilizations)), utilizations.shape)
        if not constraint.is_satisfied_at_rest.all() and utilizations[cell, block] > worst:
            worst, overload = (
                float(utilizations[cell, block]),
                (constraint.names[block], float(cells.begins[cell])),
            )
    return overload


def _stopping_distances(
    model: DrakeModel,
    request: CertifyRequest,
    cells: MotionCells,
    stops: Stops,
    deadline: Deadline,
) -> tuple[float, str, float | None, str]:
    """Return a joint's longest stopping distance, the joint, and the tool's, and its frame."""
    names, path_lengths = cells.path_length_bounds()
    longest = _max_stopping_distances(path_lengths, stops)
    joint = int(np.argmax(longest))
    frame = next(iter(request.group.tool_frames), "")
    if not frame:
        return float(longest[joint]), names[joint], None, ""
    tool_path_lengths = _tool_path_lengths(ToolRates(model, request, frame), cells, deadline)
    return (
        float(longest[joint]),
        names[joint],
        float(_max_stopping_distances(tool_path_lengths[:, None], stops)[0]),
        frame,
    )


def _max_stopping_distances(
    path_lengths: Float64[np.ndarray, "n m"], stops: Stops
) -> Float64[np.ndarray, " m"]:
    """Return the longest path length from a cell to the end of the stop that follows it."""
    traveled = np.concatenate([
        np.zeros((1, path_lengths.shape[1])),
        np.cumsum(path_lengths, axis=0),
    ])
    return (traveled[stops.ends[1:]] - traveled[:-1]).max(axis=0)


def _tool_path_lengths(
    tool: ToolRates, cells: MotionCells, deadline: Deadline
) -> Float64[np.ndarray, " n"]:
    """Bound the path length of the tool's origin in each cell [m].

    On a cell of width h with |p''| <= a, velocity differs from its mean by no more than
    a (t^2 + (h - t)^2) / (2 h): the path is longer than the chord by a h^2 / 3 at most.
    """
    coarse = tool.cells(0.0, cells.end)
    edges = np.append(cells.begins, cells.end)
    _, origins = tool.poses(edges, deadline)
    chords = np.linalg.norm(np.diff(origins, axis=0), axis=1)
    first = np.searchsorted(coarse.begins, edges[:-1], side="right") - 1
    last = np.searchsorted(coarse.begins, edges[1:], side="left") - 1
    worst = np.array([
        coarse.acceleration[max(i, 0) : max(i, j, 0) + 1].max()
        for i, j in zip(first, last, strict=True)
    ])
    return chords + worst * cells.widths**2 / 3
