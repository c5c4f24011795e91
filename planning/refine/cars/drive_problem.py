"""DriveProblem: a car's path to refine, and the conversion between paths and arc segments."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.curves.path import JointPath
from planning.domain.robot.joints import JointLimits
from planning.domain.robot.steering import Steering, manifold_of, steering_of
from planning.refine.cars.arc_segments import ArcSegments, knots_of

# Largest turning angle of one edge of a path, well below half a turn [rad].
_MOST_TURN = 2.0
# Difference in curvature, or in motion of other joints per metre, below which segments are merged.
_ALIKE = 1e-6
# Length below which the car stands still [m].
_STANDS = 1e-9


@dataclass(frozen=True)
class DriveProblem:
    """Path of a group with one car, with its steering.

    Attributes:
        path: The path to refine; none of its joints floats.
        steering: Of the car.
        at: Index of the car's first coordinate in q, and in v.
        others: Indices of the other joints' coordinates.
        rows: The path's waypoints without jumps by full turns, shape (n, nq).
    """

    path: JointPath
    steering: Steering
    at: int
    others: list[int]
    rows: Float64[np.ndarray, "n nq"]

    @classmethod
    def of(cls, path: JointPath) -> "DriveProblem":
        """Return the problem of a path of a group with one car and no floating joint."""
        ((name, steering),) = steering_of(path.group).items()
        at = path.group.velocity_names.index(f"{name}.x")
        others = [i for i in range(path.group.num_positions) if not at <= i < at + 3]
        return cls(path, steering, at, others, path.continuous.waypoints)

    @property
    def start(self) -> Float64[np.ndarray, "3"]:
        """The car's x, y and yaw at the start."""
        return self.rows[0, self.at : self.at + 3]

    @property
    def goal(self) -> Float64[np.ndarray, "3"]:
        """The car's x, y and yaw at the goal."""
        return self.rows[-1, self.at : self.at + 3]

    @property
    def letters(self) -> ArcSegments:
        """The path as arc segments, with consecutive edges of equal curvature merged."""
        deltas = manifold_of(self.path.group).minus(self.rows[1:], self.rows[:-1])
        moves = np.abs(deltas).max(axis=1) > _STANDS
        rows = self.rows[np.append(True, moves)]
        deltas = deltas[moves]
        ways, turns = deltas[:, self.at], deltas[:, self.at + 2]
        safe = np.where(np.abs(ways) > _STANDS, ways, np.inf)
        tightest = 1 / self.steering.turning_radius
        bends = np.clip(turns / safe, -tightest, tightest)
        letters = ArcSegments(ways, bends, rows[:, self.others])
        i = 0
        while i + 1 < len(letters):
            if _goes_on(letters, i):
                letters = letters.with_one_of(i)
            else:
                i += 1
        return letters

    def path_of(self, letters: ArcSegments) -> JointPath:
        """Return segments that end at the goal as a path; long arcs are cut."""
        counts = np.maximum(1, np.ceil(np.abs(letters.turns) / _MOST_TURN)).astype(int)
        owners = np.repeat(np.arange(len(letters)), counts)
        places = np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
        begins = letters.others[owners] + (places / counts[owners])[:, None] * letters.moves[owners]
        others = np.concatenate([begins, letters.others[-1:]])
        cut = ArcSegments(letters.ways[owners] / counts[owners], letters.bends[owners], others)
        spots, yaws = knots_of(self.start, cut)
        rows = self.positions(np.stack([spots.real, spots.imag, yaws], axis=1), others)
        rows[-1] = self.rows[-1]
        return JointPath(self.path.group, rows)

    def positions(
        self, poses: Float64[np.ndarray, "m 3"], others: Float64[np.ndarray, "m k"]
    ) -> Array:
        """Return configurations of the whole group, shape (m, nq)."""
        rows = np.empty((len(poses), self.rows.shape[1]))
        rows[:, self.at : self.at + 3] = poses
        rows[:, self.others] = others
        return rows

    def about_start(self, limits: JointLimits, held: tuple[int, ...]) -> JointLimits:
        """Return limits, with those of angles on a circle shifted by full turns to the start.

        Held coordinates have equal lower and upper limits.
        """
        wraps = [wrap for joint in self.path.group.joints for wrap in joint.wraps]
        is_bounded = np.array(wraps) & np.isfinite(limits.lower) & np.isfinite(limits.upper)
        bounded = np.flatnonzero(is_bounded)
        lower, upper = np.array(limits.lower), np.array(limits.upper)
        beyond = self.rows[0, bounded] - (lower[bounded] + upper[bounded]) / 2
        turns = 2 * np.pi * np.round(beyond / (2 * np.pi))
        lower[bounded], upper[bounded] = lower[bounded] + turns, upper[bounded] + turns
        lower[list(held)] = upper[list(held)] = self.rows[0, list(held)]
        return replace(limits, lower=lower, upper=upper)


def _goes_on(letters: ArcSegments, i: int) -> bool:
    """Return whether segment i + 1 continues segment i with equal direction and curvature."""
    first, second = letters.ways[i : i + 2]
    rates = letters.moves[i] * second - letters.moves[i + 1] * first
    return bool(
        first * second > 0
        and abs(letters.bends[i] - letters.bends[i + 1]) <= _ALIKE
        and (np.abs(rates) <= _ALIKE * abs(first * second)).all()
    )
