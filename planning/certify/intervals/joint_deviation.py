"""Joint deviation: segments of a trajectory, each with a configuration and bounds on joint motion.

For a segment of many pieces the reference is its middle piece: the deviation of a joint is at most
the distance of two pieces' middles plus the deviation within the other piece. For a segment within
one piece the Bernstein coefficients c_i of the tangent bound it: |delta(t) - delta(t_m)| is at most
the largest |c_i - delta(t_m)|, as a norm is convex. A floating joint rotates by no more than its
tangent moves, for exp is 1-Lipschitz from R^3 to SO(3): its Jacobian's singular values, 1 and
|sin(x/2) / (x/2)|, are at most 1.

Where a piece does not end where the next one begins, the joints move from one to the other: the
deviation within a piece includes that jump, and rounding errors (`rounding`).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals import bernstein
from planning.certify.intervals.jumps import position_jumps, unwrap_turns
from planning.certify.intervals.rounding import rounding_bounds
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
        max_rotation: Largest rotation of each joint from there [rad], shape (num_joints,).
        max_translation: Largest translation of each joint from there [m], shape (num_joints,).
        pieces: First piece, and the one after the last.
        bernstein: Coefficients of the tangent, for a segment within one piece.
    """

    begin: float
    end: float
    time: float
    center: Float64[np.ndarray, " nq"]
    max_rotation: Float64[np.ndarray, " num_joints"]
    max_translation: Float64[np.ndarray, " num_joints"]
    pieces: tuple[int, int]
    bernstein: Float64[np.ndarray, "k nv"]

    @property
    def is_within_piece(self) -> bool:
        """Whether the segment lies within one piece."""
        return self.pieces[1] - self.pieces[0] == 1


class Segments:
    """Bisection of one trajectory into segments, from the whole to parts of pieces."""

    def __init__(self, trajectory: TimedTrajectory) -> None:
        """Bound the joint motion on every piece."""
        self._curve = curve = unwrap_turns(trajectory)
        self._rotation_selection, self._translation_selection = _selections(curve.joints)
        self._bernstein = bernstein.from_power(curve.coefficients, np.diff(curve.breaks))
        left, _ = bernstein.halves(self._bernstein)
        self._centers = curve.manifold.plus(curve.bases, left[:, -1])
        squared_deviations = (self._bernstein - left[:, -1:]) ** 2
        squared_gaps = self._gaps_and_rounding() ** 2
        self._gap_rotation, self._gap_translation = (
            np.sqrt(squared_gaps @ selection)
            for selection in (self._rotation_selection, self._translation_selection)
        )
        self._max_rotation = (
            np.sqrt(squared_deviations @ self._rotation_selection).max(axis=1) + self._gap_rotation
        )
        self._max_translation = (
            np.sqrt(squared_deviations @ self._translation_selection).max(axis=1)
            + self._gap_translation
        )

    def _gaps_and_rounding(self) -> Array:
        """Bound the gap between each piece and the next, and the rounding errors of the piece."""
        curve = self._curve
        largest = np.abs(self._bernstein).max(axis=1)
        bounds = rounding_bounds(largest, curve.coefficients, np.diff(curve.breaks))
        begins, ends = (curve.manifold.plus(curve.bases, self._bernstein[:, i]) for i in (0, -1))
        bounds[:-1] += np.abs(position_jumps(curve, begins, ends))
        return bounds

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
            self._piece_segment(first, (segment.begin, middle), left),
            self._piece_segment(first, (middle, segment.end), right),
        )

    def _range(self, first: int, last: int) -> Segment:
        breaks = self._curve.breaks
        middle = (first + last) // 2
        squared_displacements = (
            self._displacements(self._centers[first:last], self._centers[middle]) ** 2
        )
        return Segment(
            begin=float(breaks[first]),
            end=float(breaks[last]),
            time=float(breaks[middle] + breaks[middle + 1]) / 2,
            center=self._centers[middle],
            max_rotation=(
                np.sqrt(squared_displacements @ self._rotation_selection)
                + self._max_rotation[first:last]
            ).max(axis=0),
            max_translation=(
                np.sqrt(squared_displacements @ self._translation_selection)
                + self._max_translation[first:last]
            ).max(axis=0),
            pieces=(first, last),
            bernstein=self._bernstein[first],
        )

    def _piece_segment(self, piece: int, span: tuple[float, float], coefficients: Array) -> Segment:
        middle = bernstein.halves(coefficients)[0][-1]
        squared_deviations = (coefficients - middle) ** 2
        return Segment(
            begin=span[0],
            end=span[1],
            time=(span[0] + span[1]) / 2,
            center=self._curve.manifold.plus(self._curve.bases[piece], middle),
            max_rotation=np.sqrt(squared_deviations @ self._rotation_selection).max(axis=0)
            + self._gap_rotation[piece],
            max_translation=np.sqrt(squared_deviations @ self._translation_selection).max(axis=0)
            + self._gap_translation[piece],
            pieces=(piece, piece + 1),
            bernstein=coefficients,
        )

    def _displacements(self, q1: Array, q0: Array) -> Array:
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
    rotations, translations = np.zeros((count, len(joints))), np.zeros((count, len(joints)))
    begin = 0
    for k, joint in enumerate(joints):
        match joint.type:
            case JointType.REVOLUTE | JointType.CONTINUOUS:
                rotations[begin, k] = 1
            case JointType.PRISMATIC:
                translations[begin, k] = 1
            case JointType.PLANAR:
                translations[begin : begin + 2, k] = rotations[begin + 2, k] = 1
            case JointType.FLOATING:
                rotations[begin : begin + 3, k] = translations[begin + 3 : begin + 6, k] = 1
        begin += joint.num_velocities
    return rotations, translations
