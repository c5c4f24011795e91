"""Line check: sections of a motion follow straight lines of a tool (linear moves) at every instant.

Let f(t) be the deviation: for the origin its distance from the segment, for the rotation the matrix
R(t) - S(s(t)), with S the line's rotation at the fraction s of the line that the origin has passed.
The origin is within h^2 / 8 max |p''| of the chord between two samples h apart, and the distance
from a segment is convex; so is a norm. Hence on every interval between samples

    |f| <= max(|f(a)|, |f(b)|) + h^2 / 8 max |p''|    (of R - S: its second derivative's bound).

The bounds of second derivatives are those of `ToolRates` and hold on whole cells. Lines with almost
no translation have no such fraction: for them the axis of rotation is compared with the line's
axis instead, where R n - n_W takes the place of R - S. Rounding errors of the tool's pose are
added to both.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.certify.frames.frame_derivative_bounds import direction_bounds, origin_bounds
from planning.certify.frames.tool_rates import RateCells, ToolRates
from planning.certify.intervals.equal_split import split_equally
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.goals.linear_moves import LineSection, ToolLine
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Share of the tolerance that the bound between samples may use.
_INTERPOLATION_FRACTION = 0.02
_MAX_SAMPLES = 50_000
# A line with a shorter translation than this per rotation is a pure rotation [m per rad], or [m].
_MIN_TRANSLATION_PER_ROTATION = 0.02
_MIN_LENGTH = 1e-4


@dataclass(frozen=True)
class _WorstDeviation:
    """The largest bound of a deviation, and its instant [s]."""

    value: float
    time: float


def line_checks(model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> list[Check]:
    """Return the checks of the tool's position and rotation errors, on the worst section.

    Values are guaranteed bounds. Without a section there is no check.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    checks: list[Check] = []
    for section in request.lines:
        position_deviation, rotation_deviation = _worst_deviations(
            model, request, section, deadline
        )
        name = section.line.frame
        checks += [
            Check(
                "line",
                position_deviation.value,
                section.max_position_deviation,
                "m",
                0.0,
                position_deviation.value <= section.max_position_deviation,
                name,
                position_deviation.time,
            ),
            Check(
                "line rotation",
                rotation_deviation.value,
                section.max_rotation_deviation,
                "rad",
                0.0,
                rotation_deviation.value <= section.max_rotation_deviation,
                name,
                rotation_deviation.time,
            ),
        ]
    return _worst_of(checks, "line") + _worst_of(checks, "line rotation")


def _worst_of(checks: list[Check], name: str) -> list[Check]:
    """Return the check with a given name that has the largest utilization, if there is one."""
    named = [check for check in checks if check.name == name]
    return [max(named, key=lambda check: check.value / check.bound)] if named else []


def _worst_deviations(
    model: DrakeModel, request: CertifyRequest, section: LineSection, deadline: Deadline
) -> tuple[_WorstDeviation, _WorstDeviation]:
    rates = ToolRates(model, request, section.line.frame)
    cells = rates.cells(section.begin, section.end)
    rotation_accelerations = _rotation_accelerations(section.line, cells)
    # Chord of the allowed angle, in the norm of the rotation errors below.
    chord = 2 * np.sqrt(2) * np.sin(section.max_rotation_deviation / 2)
    squared_densities = np.maximum(
        cells.acceleration / (8 * _INTERPOLATION_FRACTION * section.max_position_deviation),
        rotation_accelerations / (8 * _INTERPOLATION_FRACTION * chord),
    )
    counts = np.maximum(1, np.ceil(cells.widths * np.sqrt(squared_densities))).astype(np.int64)
    scale = max(1.0, counts.sum() / _MAX_SAMPLES)
    counts = np.maximum(1, np.floor(counts / scale)).astype(np.int64)
    owners, within = split_equally(counts)
    steps = (cells.widths / counts)[owners]
    times = np.append(cells.begins[owners] + within * steps, section.end)
    R_WT, p_wt = rates.poses(times, deadline)
    step_factors = steps**2 / 8
    position_error, rotation_error = _rounding_errors(model, request, section.line)
    position_bounds = (
        _interval_maxima(_distances(section.line, p_wt))
        + step_factors * cells.acceleration[owners]
        + position_error
    )
    rotation_norms = (
        _interval_maxima(_rotation_errors(section.line, R_WT, p_wt))
        + step_factors * rotation_accelerations[owners]
        + rotation_error
    )
    angles = 2 * np.arcsin(np.minimum(rotation_norms / (2 * np.sqrt(2)), 1.0))
    return _largest(position_bounds, times), _largest(angles, times)


def _rounding_errors(
    model: DrakeModel, request: CertifyRequest, line: ToolLine
) -> tuple[float, float]:
    """Bound the rounding errors of the distances [m] and of the rotation norms."""
    frame_arguments = model, request, line.frame
    position_error, rotation_error = (
        origin_bounds(*frame_arguments).errors[:, 0].max(),
        np.sqrt(3) * direction_bounds(*frame_arguments).errors[:, 0].max(),
    )
    if _has_translation(line):
        rotation_error += (
            np.sqrt(2) * float(np.linalg.norm(line.rotation_vector)) * position_error / line.length
        )
    return float(position_error), float(rotation_error)


def _interval_maxima(at_samples: Array) -> Array:
    return np.maximum(at_samples[:-1], at_samples[1:])


def _largest(values: Array, times: Array) -> _WorstDeviation:
    worst = int(np.argmax(values))
    return _WorstDeviation(float(values[worst]), float(times[worst]))


def _has_translation(line: ToolLine) -> bool:
    return line.length > max(
        _MIN_LENGTH, _MIN_TRANSLATION_PER_ROTATION * float(np.linalg.norm(line.rotation_vector))
    )


def _rotation_accelerations(line: ToolLine, cells: RateCells) -> Array:
    """Bound the second derivative of the rotation error matrix, in the Frobenius norm [1/s^2].

    |R''| <= sqrt(2) (|omega'| + |omega|^2), and S'' = S_ss s'^2 + S_s s'' in the same way.
    """
    tool_term = cells.angular_acceleration + cells.angular_speed**2
    angle = float(np.linalg.norm(line.rotation_vector))
    if not _has_translation(line):
        return np.sqrt(2) * tool_term
    rate, change = cells.speed / line.length, cells.acceleration / line.length
    return np.sqrt(2) * (tool_term + (angle * rate) ** 2 + angle * change)


def _distances(line: ToolLine, p_wt: Float64[np.ndarray, "n 3"]) -> Array:
    """Return the distances of points from the segment [m]."""
    fractions = np.clip(_fractions(line, p_wt), 0.0, 1.0)
    nearest = line.begin.position + fractions[:, None] * line.translation
    return np.linalg.norm(p_wt - nearest, axis=1)


def _fractions(line: ToolLine, p_wt: Array) -> Array:
    translation = line.translation
    return (
        (p_wt - line.begin.position) @ translation / max(float(translation @ translation), 1e-300)
    )


def _rotation_errors(line: ToolLine, R_WT: Array, p_wt: Array) -> Array:
    """Return the norms of the rotation errors, comparable with |R - S|."""
    if _has_translation(line):
        rotations = rotation.exp(_fractions(line, p_wt)[:, None] * line.rotation_vector)
        expected = rotation.matrix(rotation.multiply(line.begin.quaternion[None], rotations))
        return np.linalg.norm(R_WT - expected, axis=(1, 2))
    angle = float(np.linalg.norm(line.rotation_vector))
    start = rotation.matrix(line.begin.quaternion)
    if angle < 1e-9:
        return np.linalg.norm(R_WT - start, axis=(1, 2))
    axis = line.rotation_vector / angle
    # A tilt moves the axis by the chord of its angle; the matrix norm is sqrt(2) times that.
    return np.sqrt(2) * np.linalg.norm((R_WT - start) @ axis, axis=1)
