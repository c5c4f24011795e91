"""DrakeModel: a scene's Drake objects (plant, scene graph, diagram), borrowed read-only."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.geometry import GeometryId, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Frame, JointIndex
from pydrake.planning import RobotDiagram

from planning.domain.arrays import Array, Indices
from planning.domain.geometry.unchecked_pair import UncheckedReason
from planning.domain.robot.joints import JointGroup
from planning.world.collision.static_objects import StaticObjects
from planning.world.offset_frame import OffsetFrame

type UncheckedReasons = Mapping[frozenset[str], tuple[UncheckedReason, str]]


@dataclass(frozen=True)
class Coupling:
    """Mimic joint of a plant, as indices of follower and leader into q and into v."""

    follower_position: int
    leader_position: int
    follower_velocity: int
    leader_velocity: int
    multiplier: float
    offset: float


@dataclass(frozen=True, eq=False)
class DrakeModel:
    """Scene in Drake. Never leaves the process, never crosses a stage as a value.

    Attributes:
        diagram: Owns the plant and the scene graph; stages make their own contexts of it.
        plant: Finalized.
        scene_graph: With every allowed collision filtered out.
        body_names: Full name of every body of the plant.
        bodies: The same, by full name.
        frames: Drake's frames by full name; "world" is one of them.
        joint_indices: Drake's joint by full name.
        couplings: Mimic joints, none before its leader; the plant itself does not have them.
        owners: The robot of each attached object, by the object's name.
        static_objects: Objects outside of the plant and the scene graph.
        half_spaces: The body of each half space that is fixed to the world, by the id of its visual
            geometry; Drake has no collision geometry of it (docs/decisions/0074).
        uses_kernel: Whether the native kernel may decide where it is certain, or Drake always does.
        unchecked_reasons: Reasons for the pairs of bodies that we left out of collision checks.
        warnings: Warnings of the builder.
    """

    diagram: RobotDiagram
    plant: MultibodyPlant
    scene_graph: SceneGraph
    body_names: Mapping[BodyIndex, str]
    bodies: Mapping[str, BodyIndex]
    frames: Mapping[str, Frame]
    joint_indices: Mapping[str, JointIndex]
    couplings: tuple[Coupling, ...]
    owners: Mapping[str, str] = field(default_factory=dict)
    static_objects: StaticObjects = field(default_factory=StaticObjects)
    half_spaces: Mapping[GeometryId, str] = field(default_factory=dict)
    uses_kernel: bool = True
    unchecked_reasons: UncheckedReasons = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    _index_cache: dict[tuple[str, ...], tuple[Indices, Indices]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @cached_property
    def all_bodies(self) -> frozenset[str]:
        """Full names of the plant's bodies and of the objects outside of it."""
        return frozenset({*self.bodies, *self.static_objects.rows})

    @property
    def all_frames(self) -> set[str]:
        """Full names of Drake's frames and of the frames of objects outside of its plant."""
        return {*self.frames, *self.static_objects.frames}

    def frame(self, name: str) -> OffsetFrame:
        """Return the frame of a name that exists."""
        X_WF = self.static_objects.frames.get(name)
        if X_WF is not None:
            return OffsetFrame(self.plant.world_frame(), X_WF)
        return OffsetFrame(self.frames[name])

    @property
    def mimics(self) -> tuple[tuple[int, int, float], ...]:
        """(follower, leader, multiplier) of every coupling, as indices into v."""
        return tuple((c.follower_velocity, c.leader_velocity, c.multiplier) for c in self.couplings)

    def followers_of(self, group: JointGroup) -> tuple[Coupling, ...]:
        """Return the followers of a group's joints, directly or through other followers."""
        moved_velocities = set(self.velocity_indices(group).tolist())
        found: list[Coupling] = []
        for c in self.couplings:
            if c.leader_velocity in moved_velocities:
                moved_velocities.add(c.follower_velocity)
                found.append(c)
        return tuple(found)

    def position_indices(self, group: JointGroup) -> Indices:
        """Return the indices of the group's q in the plant's, shape (nq,)."""
        return self._indices(group)[0]

    def velocity_indices(self, group: JointGroup) -> Indices:
        """Return the indices of the group's v in the plant's, shape (nv,)."""
        return self._indices(group)[1]

    def embed(
        self,
        group: JointGroup,
        q: Float64[np.ndarray, "*n nq"],
        state: Float64[np.ndarray, " num_positions"],
    ) -> Array:
        """Return full configurations: the group at q, mimics following, the rest at `state`."""
        full = np.empty((*q.shape[:-1], len(state)))
        full[...] = state
        full[..., self.position_indices(group)] = q
        return self.apply_couplings(full)

    def apply_couplings(self, full: Float64[np.ndarray, "*n num_positions"]) -> Array:
        """Set every mimic joint in `full` to its leader's multiple, and return `full`."""
        for c in self.couplings:
            full[..., c.follower_position] = c.multiplier * full[..., c.leader_position] + c.offset
        return full

    def _indices(self, group: JointGroup) -> tuple[Indices, Indices]:
        """Return both index arrays, cached by group."""
        names = group.joint_names
        found = self._index_cache.get(names)
        if found is None:
            joints: list[Any] = [self.plant.get_joint(self.joint_indices[name]) for name in names]
            in_q = [_range(j.position_start(), j.num_positions()) for j in joints]
            in_v = [_range(j.velocity_start(), j.num_velocities()) for j in joints]
            found = self._index_cache[names] = _stacked(in_q), _stacked(in_v)
        return found


def _range(first: int, count: int) -> Indices:
    return np.arange(first, first + count)


def _stacked(parts: list[Indices]) -> Indices:
    stacked = np.concatenate(parts)
    stacked.flags.writeable = False
    return stacked
