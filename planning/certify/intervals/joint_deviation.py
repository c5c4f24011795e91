"""Joint deviation: segments of a trajectory, each with a configuration and bounds on joint motion.

For a segment of many pieces the reference is its middle piece: the deviation of a joint is at most
the distance of two pieces' middles plus the deviation within the other piece. For a segment within
one piece the Bernstein coefficients c_i of the tangent bound it: |delta(t) - delta(t_m)| is at most
the largest |c_i - delta(t_m)|, as a norm is convex. A floating joint rotates by no more than its
tangent moves, for exp is 1-Lipschitz from R^3 to SO(3): its Jacobian's singular values, 1 and
|sin(x/2) / (x/2)|, are at most 1.
Where a piece ends off the beginning of the next one, the joints move from one to the other: the
deviation within a piece includes that jump, and rounding errors (`rounding`).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals import bernstein
from planning.certify.intervals.jumps import in_one_turn, position_jumps
from planning.certify.intervals.rounding import rounding
from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import Joint, JointType


@dataclass(frozen=True)
class Segment:
    """A time interval of a trajectory, with a configuration and bounds on the deviation from it.

    Attributes:
        begin: First instant [s].
        end: Last instant [s].
        time: Instant of the configuration `center` [s].
        center: Configuration q of the group at `time`, shape (nq,).
        turn: Largest rotation of each joint from there [rad], shape (num_joints,).
        shift: Largest translation of each joint from there [m], shape (num_joints,).
        pieces: First piece, and the one after the last.
        bernstein: Coefficients of the tangent, for a segment within one piece.
    """

    begin: float
    end: float
    time: float
    center: Float64[np.ndarray, " nq"]
    turn: Float64[np.ndarray, " num_joints"]
    shift: Float64[np.ndarray, " num_joints"]
    pieces: tuple[int, int]
    bernstein: Float64[np.ndarray, "k nv"]

    @property
    def is_part(self) -> bool:
        """Whether the segment lies within one piece."""
        return self.pieces[1] - self.pieces[0] == 1


class Segments:
    """Bisection of one trajectory into segments, from the whole to parts of pieces."""

    def __init__(self, trajectory: TimedTrajectory) -> None:
        """Bound the joint motion on every piece."""
        self._curve = curve = in_one_turn(trajectory)
        self._turns, self._shifts = _selections(curve.joints)
        self._bernstein = bernstein.from_power(curve.coefficients, np.diff(curve.breaks))
        left, _ = bernstein.halves(self._bernstein)
        self._centers = curve.manifold.plus(curve.bases, left[:, -1])
        stray, loose = (self._bernstein - left[:, -1:]) ** 2, self._loose() ** 2
        self._loose_turn, self._loose_shift = (
            np.sqrt(loose @ chosen) for chosen in (self._turns, self._shifts)
        )
        self._turn = np.sqrt(stray @ self._turns).max(axis=1) + self._loose_turn
        self._shift = np.sqrt(stray @ self._shifts).max(axis=1) + self._loose_shift

    def _loose(self) -> Array:
        """Bound the gap between each piece and the next, and the rounding errors of the piece."""
        curve = self._curve
        largest = np.abs(self._bernstein).max(axis=1)
        off = rounding(largest, curve.coefficients, np.diff(curve.breaks))
        begins, ends = (curve.manifold.plus(curve.bases, self._bernstein[:, i]) for i in (0, -1))
        off[:-1] += np.abs(position_jumps(curve, begins, ends))
        return off

    @property
    def whole(self) -> Segment:
        """The whole trajectory."""
        return self._range(0, self._curve.num_pieces)

    def halves(self, segment: Segment) -> tuple[Segment, Segment]:
        """Return two segments that cover a segment."""
        first, last = segment.pieces
        if last - first > 1:
            middle = (first + last) // 2
            return self._range(first, middle), self._range(middle, last)
        middle = (segment.begin + segment.end) / 2
        left, right = bernstein.halves(segment.bernstein)
        return (
            self._part(first, (segment.begin, middle), left),
            self._part(first, (middle, segment.end), right),
        )

    def _range(self, first: int, last: int) -> Segment:
        breaks = self._curve.breaks
        middle = (first + last) // 2
        moved = self._between(self._centers[first:last], self._centers[middle]) ** 2
        return Segment(
            begin=float(breaks[first]),
            end=float(breaks[last]),
            time=float(breaks[middle] + breaks[middle + 1]) / 2,
            center=self._centers[middle],
            turn=(np.sqrt(moved @ self._turns) + self._turn[first:last]).max(axis=0),
            shift=(np.sqrt(moved @ self._shifts) + self._shift[first:last]).max(axis=0),
            pieces=(first, last),
            bernstein=self._bernstein[first],
        )

    def _part(self, piece: int, span: tuple[float, float], coefficients: Array) -> Segment:
        middle = bernstein.halves(coefficients)[0][-1]
        stray = (coefficients - middle) ** 2
        return Segment(
            begin=span[0],
            end=span[1],
            time=(span[0] + span[1]) / 2,
            center=self._curve.manifold.plus(self._curve.bases[piece], middle),
            turn=np.sqrt(stray @ self._turns).max(axis=0) + self._loose_turn[piece],
            shift=np.sqrt(stray @ self._shifts).max(axis=0) + self._loose_shift[piece],
            pieces=(piece, piece + 1),
            bernstein=coefficients,
        )

    def _between(self, q1: Array, q0: Array) -> Array:
        """Return a displacement per velocity coordinate, shape (m, nv), with whole turns.

        Whole turns leave the joint itself in place, but not a follower with another multiplier.
        For a rotation in space only the angle is returned, in the first of its three coordinates.
        """
        parts: list[Array] = []
        begin = 0
        for joint in self._curve.joints:
            end = begin + joint.num_positions
            if joint.type is JointType.FLOATING:
                angle = _angle(q1[:, begin : begin + 4], q0[begin : begin + 4])
                parts += [angle[:, None], np.zeros((len(q1), 2))]
                begin += 4
            parts.append(q1[:, begin:end] - q0[begin:end])
            begin = end
        return np.concatenate(parts, axis=1)


def _angle(a: Array, b: Array) -> Array:
    """Return the angle between unit quaternions [rad], from the chord between them.

    |a - b| = 2 sin(angle / 4), for the nearer of b and -b: well conditioned for small angles.
    """
    chord = np.minimum(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return 4 * np.arcsin(np.minimum(chord / 2, 1.0))


def _selections(joints: tuple[Joint, ...]) -> tuple[Array, Array]:
    """Return which velocity coordinates rotate and translate each joint, shape (nv, num_joints)."""
    count = sum(joint.num_velocities for joint in joints)
    turns, shifts = np.zeros((count, len(joints))), np.zeros((count, len(joints)))
    begin = 0
    for k, joint in enumerate(joints):
        match joint.type:
            case JointType.REVOLUTE | JointType.CONTINUOUS:
                turns[begin, k] = 1
            case JointType.PRISMATIC:
                shifts[begin, k] = 1
            case JointType.PLANAR:
                shifts[begin : begin + 2, k] = turns[begin + 2, k] = 1
            case JointType.FLOATING:
                turns[begin : begin + 3, k] = shifts[begin + 3 : begin + 6, k] = 1
        begin += joint.num_velocities
    return turns, shifts
