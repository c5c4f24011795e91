"""Kinematic tree of a loaded world in the native kernel, without its geometry."""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from jaxtyping import Float64
from pydrake.math import RigidTransform
from pydrake.planning import RobotDiagram

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup
from planning.kernel.native import native
from planning.world.drake_model import DrakeModel
from planning.world.kernel.link_tree import LinkTree, link_tree

_cache: WeakKeyDictionary[RobotDiagram, tuple[Any, LinkTree] | None] = WeakKeyDictionary()
# Chains of a diagram, by joints, frame and state: goals, limits and reports ask for the same.
_chains: WeakKeyDictionary[RobotDiagram, dict[tuple[Any, ...], Any]] = WeakKeyDictionary()
_MAX_CHAINS = 64


def kernel_chain(
    model: DrakeModel, group: JointGroup, state: Float64[np.ndarray, " num_positions"], frame: str
) -> Any | None:
    """Return the kernel's Chain: kinematics of a frame by the group's q, other joints at `state`.

    None if there is no kernel, the model does not use it, or it has a joint of a kind that the
    kernel does not have: Drake alone computes then.
    """
    module, known = native(), tree_scene(model)
    if module is None or known is None:
        return None
    chains = _chains.setdefault(model.diagram, {})
    key = group.joint_names, frame, state.tobytes()
    # Frames of objects outside of Drake's model are not the same in all models of a diagram.
    found = chains.get(key) if frame in model.frames else None
    if found is None:
        found = _make_chain(model, group, state, frame, known)
        if len(chains) >= _MAX_CHAINS:
            chains.clear()
        if frame in model.frames:
            chains[key] = found
    return found


def _make_chain(
    model: DrakeModel, group: JointGroup, state: Array, frame: str, known: tuple[Any, LinkTree]
) -> Any:
    module: Any = native()
    scene, tree = known
    tool = model.frame(frame)
    link, x_lb = tree.bodies[int(tool.body)]
    return module.Chain(
        scene,
        model.position_indices(group).astype(np.int64),
        model.velocity_indices(group).astype(np.int64),
        model.apply_couplings(np.array(state)),
        link,
        flat_transform(x_lb.multiply(tool.pose_in_body)),
    )


def tree_scene(model: DrakeModel) -> tuple[Any, LinkTree] | None:
    """Return the kernel's Scene with the tree alone, and the tree, cached by model.

    None if there is no kernel, the model does not use it, or it has a joint of a kind that the
    kernel does not have.
    """
    if not model.uses_kernel:
        return None
    if model.diagram not in _cache:
        _cache[model.diagram] = _tree(model)
    return _cache[model.diagram]


def add_tree(scene: Any, model: DrakeModel, tree: LinkTree) -> None:
    """Add the model's links, joints and couplings to the kernel's Scene."""
    module: Any = native()
    for link in tree.links:
        scene.add_link(
            link.parent,
            flat_transform(link.X_PF),
            module.JointKind[link.kind.name],
            link.axis,
            link.position,
            link.velocity,
        )
    for c in model.couplings:
        scene.add_follower(
            c.follower_position,
            c.leader_position,
            c.follower_velocity,
            c.leader_velocity,
            c.multiplier,
            c.offset,
        )


def flat_transform(x: RigidTransform) -> Array:
    """Return R, row by row, and p: the kernel's layout of a transform, shape (12,)."""
    return np.concatenate([x.rotation().matrix().ravel(), x.translation()])


def _tree(model: DrakeModel) -> tuple[Any, LinkTree] | None:
    module, tree = native(), link_tree(model)
    if module is None or tree is None:
        return None
    scene = module.Scene(model.plant.num_positions(), model.plant.num_velocities())
    add_tree(scene, model, tree)
    return scene, tree
