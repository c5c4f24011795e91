"""FramePoses: poses of a frame at the reference configuration and at instants of a trajectory."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

_BATCH_SIZE = 256


class FramePoses:
    """Poses of one frame along one trajectory, by Drake in a context of its own."""

    def __init__(self, model: DrakeModel, request: CertifyRequest, name: str) -> None:
        """Prepare; the frame must exist."""
        self._model, self._request = model, request
        self._frame = model.frame(name)
        self._context: Any = model.plant.CreateDefaultContext()

    def at_reference(self) -> Float64[np.ndarray, "4 4"]:
        """Return X_WF with the group at the request's reference configuration."""
        return self._poses(self._request.reference[None])[0]

    def at(
        self, pieces: Any, local: Float64[np.ndarray, " n"], deadline: Deadline
    ) -> Float64[np.ndarray, "n 4 4"]:
        """Return X_WF at instants of given pieces, also where two pieces meet.

        Args:
            pieces: Index of the piece of each instant, shape (n,).
            local: Time since the beginning of the piece [s].
            deadline: Time limit.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        curve = self._request.trajectory
        powers = local[:, None] ** np.arange(curve.coefficients.shape[1])
        tangents = np.einsum("nk,nkv->nv", powers, curve.coefficients[pieces])
        q = curve.manifold.plus(curve.bases[pieces], tangents)
        batches: list[Array] = []
        for begin in range(0, len(q), _BATCH_SIZE):
            deadline.check("certify")
            batches.append(self._poses(q[begin : begin + _BATCH_SIZE]))
        return np.concatenate(batches) if batches else np.zeros((0, 4, 4))

    def _poses(self, qs: Array) -> Array:
        plant, context, frame = self._model.plant, self._context, self._frame
        poses = np.empty((len(qs), 4, 4))
        for i, q in enumerate(self._model.embed(self._request.group, qs, self._request.state)):
            plant.SetPositions(context, q)
            poses[i] = frame.pose(context).GetAsMatrix4()
        return poses
