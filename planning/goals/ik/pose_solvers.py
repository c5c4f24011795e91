"""PoseSolver: numerical IK from seeds, by the native kernel (batched) or by Drake (one by one)."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float64, Int64

from planning.domain.arrays import Array, Flags
from planning.domain.geometry import rotation
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointGroup
from planning.goals.ik.ik_program import IkProgram
from planning.goals.targets.tool_target import ToolTarget
from planning.kernel.native import native
from planning.world.kernel.kernel_tree import kernel_chain
from planning.world.world import World

_MAX_ITERATIONS = 30


@runtime_checkable
class PoseSolver(Protocol):
    """Interface of an IK solver for some targets of one tool frame, referred to by index.

    Attributes:
        batch_size: Efficient number of seeds per call.
    """

    batch_size: int

    def solve(
        self,
        seeds: Float64[np.ndarray, "n nq"],
        targets: Int64[np.ndarray, " n"],
        num_required: int,
    ) -> tuple[Bool[np.ndarray, " m"], Float64[np.ndarray, "m nq"]]:
        """Solve from seed after seed until `num_required` have converged; m <= n are tried.

        Args:
            seeds: Initial guesses.
            targets: Index of the target of each seed.
            num_required: Number of converged seeds after which the solver may stop.

        Returns:
            Whether each tried seed converged to its target within tolerance, and the result.
        """
        ...


class DrakePoseSolver:
    """IK solver by Drake's InverseKinematics, one seed at a time."""

    batch_size = 1

    def __init__(
        self, world: World, group: JointGroup, deadline: Deadline, targets: list[ToolTarget]
    ) -> None:
        """Prepare for some targets; no seed is solved after the deadline."""
        self._arguments = world, group
        self._targets = targets
        self._deadline = deadline
        self._programs: dict[int, IkProgram] = {}

    def solve(
        self,
        seeds: Float64[np.ndarray, "n nq"],
        targets: Int64[np.ndarray, " n"],
        num_required: int,
    ) -> tuple[Flags, Array]:
        """Solve as specified by `PoseSolver.solve`."""
        results: list[Array | None] = []
        for seed, target in zip(seeds, targets, strict=True):
            if num_required <= sum(q is not None for q in results) or self._deadline.is_over:
                break
            results.append(self._program(int(target)).solve(seed))
        num_tried = len(results)
        q = np.array([
            s if q is None else q for s, q in zip(seeds[:num_tried], results, strict=True)
        ])
        converged = np.array([q is not None for q in results], dtype=bool)
        return converged, q.reshape(num_tried, seeds.shape[1])

    def _program(self, index: int) -> IkProgram:
        if index not in self._programs:
            self._programs[index] = IkProgram(*self._arguments, self._targets[index])
        return self._programs[index]


class KernelPoseSolver:
    """IK solver by the native kernel: Levenberg-Marquardt, several seeds per SIMD register."""

    batch_size = 320

    def __init__(
        self,
        world: World,
        group: JointGroup,
        chain: Any,
        poses: tuple[Float64[np.ndarray, "n 3"], Float64[np.ndarray, "n 4"]],
        tolerance: Any,
    ) -> None:
        """Prepare for target poses X_WG, as p_WG [m] and quaternions, of the chain's end frame."""
        self._chain, self._tolerance = chain, tolerance
        limits = world.limits(group)
        self._limits = limits.lower, limits.upper
        rotations = rotation.matrix(poses[1]).reshape(-1, 9)
        self._targets = np.concatenate([rotations, poses[0]], axis=1)

    def solve(
        self,
        seeds: Float64[np.ndarray, "n nq"],
        targets: Int64[np.ndarray, " n"],
        num_required: int,
    ) -> tuple[Flags, Array]:
        """Solve as specified by `PoseSolver.solve`."""
        if not len(seeds):
            return np.zeros(0, dtype=bool), seeds
        converged, q, _ = self._chain.solve(
            np.ascontiguousarray(seeds),
            targets,
            self._targets,
            *self._limits,
            self._tolerance,
            num_required,
            _MAX_ITERATIONS,
        )
        return converged.astype(bool), q


def kernel_pose_solver(
    world: World, group: JointGroup, targets: list[ToolTarget]
) -> KernelPoseSolver | None:
    """Return the kernel's solver for targets of equal tolerances; None if it has no such chain."""
    chain = kernel_chain(world.drake, group, world.state, targets[0].frame)
    if chain is None:
        return None
    module: Any = native()
    rotation = targets[0].rotation_freedom
    freedom = module.Freedom[rotation.kind.name]
    tolerance = module.IkTolerance(
        targets[0].position_tolerance, freedom, rotation.axis, rotation.bound
    )
    positions = np.stack([target.pose.position for target in targets])
    quaternions = np.stack([target.pose.quaternion for target in targets])
    return KernelPoseSolver(world, group, chain, (positions, quaternions), tolerance)


def exact_kernel_solver(
    world: World,
    group: JointGroup,
    frame: str,
    poses: tuple[Float64[np.ndarray, "n 3"], Float64[np.ndarray, "n 4"]],
) -> KernelPoseSolver | None:
    """Return the kernel's solver for exact poses X_WG of a frame; None if it has no such chain.

    Args:
        world: Loaded scene.
        group: Joint group to solve for.
        frame: Full name of the tool frame.
        poses: p_WG [m] and quaternions.
    """
    chain = kernel_chain(world.drake, group, world.state, frame)
    if chain is None:
        return None
    module: Any = native()
    tolerance = module.IkTolerance(np.zeros(3), module.Freedom.BALL, 0, 0.0)
    return KernelPoseSolver(world, group, chain, poses, tolerance)
