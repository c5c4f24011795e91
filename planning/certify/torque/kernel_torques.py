"""Torque series by the native kernel: the recursions of `newton_euler` and of `torque_remainder`.

Those are the reference, and what runs without the kernel or where a link turns in space. The proof
shares nothing with the inverse dynamics that motions are made with.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64, Int

from planning.certify.torque.joint_motion import MotionKind
from planning.certify.torque.links import Link
from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.kernel.native import native


class KernelTorques:
    """Torque polynomials of one chain of links along one trajectory."""

    def __init__(self, chain: Any, trajectory: TimedTrajectory) -> None:
        """Hold a chain of the kernel."""
        self._chain, self._trajectory = chain, trajectory

    @classmethod
    def of(
        cls,
        links: tuple[Link, ...],
        gravity: Float64[np.ndarray, "3"],
        trajectory: TimedTrajectory,
    ) -> "KernelTorques | None":
        """Prepare, or return None where there is no kernel, or a link turns in space."""
        chain = kernel_chain(links, gravity, trajectory)
        return None if chain is None else cls(chain, trajectory)

    def polynomials(
        self,
        pieces: Int[np.ndarray, " n"],
        middles: Float64[np.ndarray, " n"],
        halves: Float64[np.ndarray, " n"],
        order: int,
        instruction_set: str = "",
    ) -> tuple[Float64[np.ndarray, "n k nv"], Float64[np.ndarray, "n nv"]]:
        """Return coefficients about the middles of segments, and bounds on their errors.

        Args:
            pieces: Piece of each segment.
            middles: Its middle relative to the piece's break [s].
            halves: Half of its width [s].
            order: Order of the derivative in the inertial terms; see `newton_euler`.
            instruction_set: One of the kernel's, all of which give the same numbers; "" for the
                widest.
        """
        found: tuple[Array, Array] = self._chain.polynomials(
            self._trajectory.bases,
            self._trajectory.coefficients,
            np.ascontiguousarray(pieces, dtype=np.int64),
            np.ascontiguousarray(middles),
            np.ascontiguousarray(halves),
            order,
            instruction_set,
        )
        return found


def kernel_chain(
    links: tuple[Link, ...], gravity: Float64[np.ndarray, "3"], trajectory: TimedTrajectory
) -> Any | None:
    """Return the kernel's chain of links; None without a kernel, or if a link turns in space."""
    module: Any = native()
    if module is None or any(link.motion.kind is MotionKind.SPHERICAL for link in links):
        return None
    num_velocities = trajectory.coefficients.shape[2]
    chain = module.TorqueSeries(trajectory.bases.shape[1], num_velocities, gravity)
    kinds = {
        MotionKind.REVOLUTE: module.JointKind.REVOLUTE,
        MotionKind.PRISMATIC: module.JointKind.PRISMATIC,
    }
    for link in links:
        motion = link.motion
        chain.add_link(
            link.parent,
            np.concatenate([link.X_PF[:3, :3].ravel(), link.X_PF[:3, 3]]),
            kinds[motion.kind],
            motion.axis,
            (motion.position_index, motion.velocity_index, motion.scale, motion.offset),
            (motion.damping, motion.rotor_inertia),
            _mass(link),
        )
    return chain


def _mass(link: Link) -> Array:
    """Return mass, centre of mass, principal second moments, and their directions row by row."""
    moments, directions = link.principal_second_moments
    return np.concatenate([[link.mass], link.center, moments, directions.ravel()])
