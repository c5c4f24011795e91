"""Couplings: Drake's joints of a robot, and the mimic relations among them."""

from collections.abc import Mapping, Sequence

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JointIndex

from planning.errors import ModelInvalid
from planning.world.drake_model import Coupling
from planning.world.models.model_file import Mimic


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
    """Return the mimic joints, none before its leader.

    Args:
        plant: The plant.
        indices: Of all joints, by `robot::joint`.
        mimics: Each with the name of its robot, in any order.

    Raises:
        ModelInvalid: Joints follow each other in a cycle, or a joint of several coordinates is
            among them, or a leader is fixed.
    """
    found: list[Coupling] = []
    for robot, mimic in _leaders_first(mimics):
        pair = [indices.get(f"{robot}::{name}") for name in (mimic.follower, mimic.leader)]
        if pair[0] is None:
            continue  # a fixed joint may carry a leftover mimic tag: nothing moves
        if pair[1] is None:
            joints = [mimic.follower, mimic.leader]
            message = f"robot {robot!r}: mimic joint {joints[0]!r} follows {joints[1]!r}, which is "
            message += "not a moving joint of this robot"
            raise ModelInvalid(message, {"joints": joints, "reason": message})
        follower, leader = (plant.get_joint(index) for index in pair if index)
        _validate_single_coordinates(
            robot, mimic, follower.num_velocities(), leader.num_velocities()
        )
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


def _validate_single_coordinates(robot: str, mimic: Mimic, *counts: int) -> None:
    if set(counts) != {1}:
        joints = [mimic.follower, mimic.leader]
        message = f"robot {robot!r}: mimic joint {joints[0]!r} and its leader {joints[1]!r} must "
        message += "have one coordinate each"
        raise ModelInvalid(message, {"joints": joints, "reason": message})


def _leaders_first(mimics: Sequence[tuple[str, Mimic]]) -> list[tuple[str, Mimic]]:
    """Return the same in topological order, no joint before its leader."""
    ordered: list[tuple[str, Mimic]] = []
    rest = list(mimics)
    while rest:
        followers = {(robot, mimic.follower) for robot, mimic in rest}
        ready = [entry for entry in rest if (entry[0], entry[1].leader) not in followers]
        if not ready:
            robot = rest[0][0]
            joints = sorted(mimic.follower for owner, mimic in rest if owner == robot)
            message = f"robot {robot!r}: the mimic joints {joints} form a cycle"
            raise ModelInvalid(message, {"joints": joints, "reason": message})
        ordered += ready
        rest = [entry for entry in rest if entry not in ready]
    return ordered
