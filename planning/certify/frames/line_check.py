"""Line check: sections of a motion follow straight lines of a tool (linear moves) at every instant.

Let f(t) be the deviation: for the origin its distance from the segment, for the rotation the matrix
R(t) - S(s(t)), with S the line's rotation at the fraction s of the distance that the origin has
covered.
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

from planning.certify.frames.frame_chain import direction_errors, origin_errors
from planning.certify.frames.tool_rates import RateCells, ToolRates
from planning.certify.intervals.equal_parts import split_equally
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.goals.linear_moves import LineSection, ToolLine
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Share of the tolerance that the bound between samples may use.
_LOST = 0.02
_MAX_SAMPLES = 50_000
# A line with a shorter translation than this per rotation is a pure rotation [m per rad], or [m].
_LEAST_WAY = 0.02
_SHORTEST = 1e-4


@dataclass(frozen=True)
class _Worst:
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
        shift, turn = _bounds(model, request, section, deadline)
        name = section.line.frame
        checks += [
            Check(
                "line",
                shift.value,
                section.max_shift,
                "m",
                0.0,
                shift.value <= section.max_shift,
                name,
                shift.time,
            ),
            Check(
                "line rotation",
                turn.value,
                section.max_turn,
                "rad",
                0.0,
                turn.value <= section.max_turn,
                name,
                turn.time,
            ),
        ]
    return _worst_of(checks, "line") + _worst_of(checks, "line rotation")


def _worst_of(checks: list[Check], name: str) -> list[Check]:
    """Return the check with a given name that has the largest utilization, if there is one."""
    named = [check for check in checks if check.name == name]
    return [max(named, key=lambda check: check.value / check.bound)] if named else []


def _bounds(
    model: DrakeModel, request: CertifyRequest, section: LineSection, deadline: Deadline
) -> tuple[_Worst, _Worst]:
    rates = ToolRates(model, request, section.line.frame)
    cells = rates.cells(section.begin, section.end)
    turning = _turning(section.line, cells)
    # Chord of the allowed angle, in the norm of the rotation errors below.
    chord = 2 * np.sqrt(2) * np.sin(section.max_turn / 2)
    wanted = np.maximum(
        cells.acceleration / (8 * _LOST * section.max_shift), turning / (8 * _LOST * chord)
    )
    counts = np.maximum(1, np.ceil(cells.widths * np.sqrt(wanted))).astype(np.int64)
    scale = max(1.0, counts.sum() / _MAX_SAMPLES)
    counts = np.maximum(1, np.floor(counts / scale)).astype(np.int64)
    owners, within = split_equally(counts)
    steps = (cells.widths / counts)[owners]
    times = np.append(cells.begins[owners] + within * steps, section.end)
    R_WT, p_wt = rates.poses(times, deadline)
    gaps = steps**2 / 8
    off_shift, off_turn = _errors(model, request, section.line)
    shift = _between(_distances(section.line, p_wt)) + gaps * cells.acceleration[owners] + off_shift
    matrix = _between(_misturns(section.line, R_WT, p_wt)) + gaps * turning[owners] + off_turn
    angles = 2 * np.arcsin(np.minimum(matrix / (2 * np.sqrt(2)), 1.0))
    return _largest(shift, times), _largest(angles, times)


def _errors(model: DrakeModel, request: CertifyRequest, line: ToolLine) -> tuple[float, float]:
    """Bound the rounding errors of the distances [m] and of the rotation norms."""
    moving = model, request, line.frame
    shift, turn = origin_errors(*moving)[:, 0].max(), np.sqrt(3) * direction_errors(*moving).max()
    if _has_way(line):
        turn += np.sqrt(2) * float(np.linalg.norm(line.turn)) * shift / line.length
    return float(shift), float(turn)


def _between(at_samples: Array) -> Array:
    return np.maximum(at_samples[:-1], at_samples[1:])


def _largest(values: Array, times: Array) -> _Worst:
    worst = int(np.argmax(values))
    return _Worst(float(values[worst]), float(times[worst]))


def _has_way(line: ToolLine) -> bool:
    return line.length > max(_SHORTEST, _LEAST_WAY * float(np.linalg.norm(line.turn)))


def _turning(line: ToolLine, cells: RateCells) -> Array:
    """Bound the second derivative of the rotation error matrix, in the Frobenius norm [1/s^2].

    |R''| <= sqrt(2) (|omega'| + |omega|^2), and S'' = S_ss s'^2 + S_s s'' in the same way.
    """
    own = cells.turn_acceleration + cells.turn_speed**2
    angle = float(np.linalg.norm(line.turn))
    if not _has_way(line):
        return np.sqrt(2) * own
    rate, change = cells.speed / line.length, cells.acceleration / line.length
    return np.sqrt(2) * (own + (angle * rate) ** 2 + angle * change)


def _distances(line: ToolLine, p_wt: Float64[np.ndarray, "n 3"]) -> Array:
    """Return the distances of points from the segment [m]."""
    fractions = np.clip(_fractions(line, p_wt), 0.0, 1.0)
    nearest = line.begin.position + fractions[:, None] * line.shift
    return np.linalg.norm(p_wt - nearest, axis=1)


def _fractions(line: ToolLine, p_wt: Array) -> Array:
    way = line.shift
    return (p_wt - line.begin.position) @ way / max(float(way @ way), 1e-300)


def _misturns(line: ToolLine, R_WT: Array, p_wt: Array) -> Array:
    """Return the norms of the rotation errors, comparable with |R - S|."""
    if _has_way(line):
        turned = rotation.exp(_fractions(line, p_wt)[:, None] * line.turn)
        wanted = rotation.matrix(rotation.multiply(line.begin.quaternion[None], turned))
        return np.linalg.norm(R_WT - wanted, axis=(1, 2))
    angle = float(np.linalg.norm(line.turn))
    start = rotation.matrix(line.begin.quaternion)
    if angle < 1e-9:
        return np.linalg.norm(R_WT - start, axis=(1, 2))
    axis = line.turn / angle
    # A tilt moves the axis by the chord of its angle; the matrix norm is sqrt(2) times that.
    return np.sqrt(2) * np.linalg.norm((R_WT - start) @ axis, axis=1)
