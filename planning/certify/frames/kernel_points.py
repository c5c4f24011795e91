"""Motion of a frame's origin by the native kernel: the first terms of the proof's own series.

Drake, in `frame_states`, is the reference, and what runs without the kernel or where a link on the
way to the frame turns in space.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64, Int

from planning.certify.request import CertifyRequest
from planning.certify.torque.joint_motion import MotionKind
from planning.certify.torque.kernel_torques import kernel_chain
from planning.certify.torque.links import chain_to
from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.world.drake_model import DrakeModel


class KernelPoints:
    """Motion of one frame's origin along one trajectory."""

    def __init__(self, chain: Any, trajectory: TimedTrajectory, point: Array) -> None:
        """Hold a chain of the kernel, and the origin in its last link."""
        self._chain, self._trajectory, self._point = chain, trajectory, point

    @classmethod
    def of(cls, model: DrakeModel, request: CertifyRequest, frame: str) -> "KernelPoints | None":
        """Prepare, or return None where Drake is to compute."""
        if not model.uses_kernel:
            return None
        links, point = chain_to(model, request, frame)
        if any(link.motion.kind is MotionKind.SPHERICAL for link in links):
            return None
        chain = kernel_chain(links, np.zeros(3), request.trajectory)
        return None if chain is None else cls(chain, request.trajectory, point)

    def at(
        self,
        pieces: Int[np.ndarray, " n"],
        local: Float64[np.ndarray, " n"],
        instruction_set: str = "",
    ) -> Float64[np.ndarray, "3 n 3"]:
        """Return positions [m], velocities [m/s] and accelerations [m/s^2] in world.

        Args:
            pieces: Piece of each instant.
            local: Time since the beginning of the piece [s].
            instruction_set: One of the kernel's; "" for the widest.
        """
        found: Array = self._chain.points(
            self._trajectory.bases,
            self._trajectory.coefficients,
            np.ascontiguousarray(pieces, dtype=np.int64),
            np.ascontiguousarray(local),
            self._point,
            instruction_set,
        )
        return found.transpose(1, 0, 2)
