"""SharedPairs: the pairs of bodies whose distance depends on two motions at once."""

from collections.abc import Sequence
from itertools import combinations

from planning.domain.robot.joints import JointGroup
from planning.world.collision.margins import PairMargins
from planning.world.drake_model import DrakeModel

# Margin that any two bodies keep [m].
_IGNORED_MARGIN = -1e3


class SharedPairs:
    """Motions by the bodies that they move, and pairs of bodies by pairs of motions."""

    def __init__(
        self, model: DrakeModel, groups: Sequence[JointGroup], margins: PairMargins
    ) -> None:
        """Find the bodies that each group moves, those of its followers included."""
        moved = [_moved_bodies(model, group) for group in groups]
        self.movers = {
            body: frozenset(i for i, bodies in enumerate(moved) if body in bodies)
            for body in model.bodies
        }
        self._margins = margins

    def motions_of(self, bodies: tuple[str, str]) -> frozenset[int]:
        """Return the indices of the motions on which the distance of two bodies depends."""
        a, b = bodies
        return self.movers.get(a, frozenset()) | self.movers.get(b, frozenset())

    def margins_of(self, i: int, j: int, padding: float) -> PairMargins:
        """Return margins under which only the pairs of two motions count.

        Args:
            i: Index of one motion.
            j: Index of the other.
            padding: Added to the margin of each such pair [m].
        """
        both = frozenset((i, j))
        by_pair: dict[tuple[str, str], float] = {}
        for a, b in combinations(self.movers, 2):
            key = (min(a, b), max(a, b))
            if self.motions_of((a, b)) == both:
                by_pair[key] = self._margins.of(a, b) + padding
            elif self._margins.are_of_one_robot(a, b):
                by_pair[key] = _IGNORED_MARGIN
        return PairMargins(_IGNORED_MARGIN, by_pair, self._margins.owners)


def _moved_bodies(model: DrakeModel, group: JointGroup) -> set[str]:
    """Return the names of the bodies that a group moves."""
    velocities = set(model.velocity_indices(group).tolist())
    velocities |= {c.follower_velocity for c in model.followers_of(group)}
    joints = [
        index
        for index in model.joint_indices.values()
        if model.plant.get_joint(index).velocity_start() in velocities
    ]
    moved = set(map(int, model.plant.GetBodiesKinematicallyAffectedBy(joints)))
    return {name for name, index in model.bodies.items() if int(index) in moved}
