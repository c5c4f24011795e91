"""Which joints a robot has in Drake, and which of them follow others."""

from collections.abc import Mapping, Sequence

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JointIndex

from planning.world.drake_model import Coupling
from planning.world.model_file import Mimic


def joint_indices(plant: MultibodyPlant, bodies: Mapping[str, BodyIndex]) -> dict[str, JointIndex]:
    """Return Drake's index of every joint that moves a robot's body, by `robot::joint`."""
    names = {index: name for name, index in bodies.items()}
    indices: dict[str, JointIndex] = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        robot, scoped, _ = names.get(joint.child_body().index(), "").partition("::")
        if scoped and joint.num_positions() > 0:
            indices[f"{robot}::{joint.name()}"] = index
    return indices


def couplings(
    plant: MultibodyPlant,
    indices: Mapping[str, JointIndex],
    mimics: Sequence[tuple[str, Mimic]],
) -> tuple[Coupling, ...]:
    """Return the joints that follow others, given each with the name of its robot."""
    found: list[Coupling] = []
    for robot, mimic in mimics:
        pair = [indices.get(f"{robot}::{name}") for name in (mimic.follower, mimic.leader)]
        if None in pair:
            continue  # a fixed joint may carry a leftover mimic tag: nothing moves
        follower, leader = (plant.get_joint(index) for index in pair if index)
        found.append(
            Coupling(
                follower.position_start(),
                leader.position_start(),
                follower.velocity_start(),
                leader.velocity_start(),
                mimic.multiplier,
                mimic.offset,
            )
        )
    return tuple(found)
