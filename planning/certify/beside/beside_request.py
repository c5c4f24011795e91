"""BesideRequest: two motions of disjoint groups, and the margins to prove whatever their timing."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.certify.clearance.motion_bounds import joint_chains, moving_joints
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup
from planning.domain.value import Value
from planning.world.collision.margins import PairMargins
from planning.world.drake_model import DrakeModel


@dataclass(frozen=True, eq=False)
class BesideRequest(Value):
    """Two motions of disjoint groups, whose times are independent.

    Attributes:
        groups: The groups.
        trajectories: The motion of each.
        state: Full plant positions, for all joints outside of the groups, shape (num_positions,).
        margins: Required distances between bodies.
    """

    groups: tuple[JointGroup, JointGroup]
    trajectories: tuple[TimedTrajectory, TimedTrajectory]
    state: Float64[np.ndarray, " num_positions"]
    margins: PairMargins

    @property
    def group(self) -> JointGroup:
        """Both groups as one: the joints of the first, then those of the second."""
        first, second = self.groups
        return JointGroup(
            f"{first.name}+{second.name}",
            (*first.joints, *second.joints),
            (*first.tool_frames, *second.tool_frames),
            (*first.winding, *second.winding),
        )

    @property
    def trajectory(self) -> TimedTrajectory:
        """Both groups at rest where their motions begin."""
        first, second = self.trajectories
        return TimedTrajectory.at_rest(
            self.group.joints, np.concatenate([first.start, second.start])
        )


@dataclass(frozen=True)
class BesideResult:
    """Result of a proof for two motions.

    Attributes:
        outcome: How it ended: "PROVEN", "TOO_NEAR" or "UNPROVEN".
        bodies: Full names of the bodies of the pair at which it ended, or of the measured pair with
            the smallest reserve; two empty strings without a pair.
        distance: Their signed distance [m], infinite without a pair.
        margin: Their margin [m].
        times: Instant of each motion [s].
        num_segments: Number of pairs of segments bounded.
    """

    outcome: str
    bodies: tuple[str, str]
    distance: float
    margin: float
    times: tuple[float, float]
    num_segments: int


def moved_bodies(model: DrakeModel, group: JointGroup) -> frozenset[str]:
    """Return the full names of the bodies that a group moves, attached objects included."""
    chains = joint_chains(model, moving_joints(model, group))
    names = model.body_names
    return frozenset(names[i] for i in names if chains.get(int(i)))
