"""Tool checks: speed and acceleration limits of frames, everywhere and in speed zones."""

from dataclasses import dataclass

import numpy as np

from planning.certify.frames.frame_poses import FramePoses
from planning.certify.frames.frame_proof import FrameIntervals, FrameProof, FrameQuantity
from planning.certify.frames.frame_states import FrameMotion
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import SpeedZone
from planning.world.drake_model import DrakeModel

_NAMES = {1: "tool_speed", 2: "tool_acceleration"}
_UNITS = {1: "m/s", 2: "m/s^2"}


def tool_checks(model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> list[Check]:
    """Return a check for every frame limit and every speed zone; values are guaranteed bounds.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
        ModelInvalid: A joint of a kind that cannot be certified.
    """
    by_frame: dict[str, list[FrameQuantity]] = {}
    for limit in request.tool_limits:
        for order, rate in enumerate((limit.speed, limit.acceleration), start=1):
            if rate is not None:
                quantity = _FrameRate(f"{_NAMES[order]} {limit.frame}", rate, order)
                by_frame.setdefault(limit.frame, []).append(quantity)
    for zone in request.speed_zones:
        by_frame.setdefault(zone.frame, []).append(_zone_quantity(model, request, zone))
    return [
        check
        for frame, quantities in by_frame.items()
        for check in FrameProof(model, request, frame, quantities).run(deadline)
    ]


@dataclass(frozen=True)
class _FrameRate:
    """Norm of the origin's velocity (order 1) or acceleration (order 2)."""

    name: str
    limit: float
    order: int

    @property
    def unit(self) -> str:
        return _UNITS[self.order]

    def evaluate(self, intervals: FrameIntervals) -> tuple[Array, Array]:
        values = np.stack([
            _norms(self._vectors(part)) for part in (intervals.begin, intervals.end)
        ])
        return values.max(axis=0) + intervals.deviations[self.order], values

    def _vectors(self, part: FrameMotion) -> Array:
        return part.velocity if self.order == 1 else part.acceleration


@dataclass(frozen=True)
class _SpeedInBox:
    """Norm of the origin's velocity inside a box (speed zone)."""

    name: str
    limit: float
    R_WB: Array
    p_wb: Array
    half_size: Array
    unit: str = "m/s"

    def evaluate(self, intervals: FrameIntervals) -> tuple[Array, Array]:
        face_distances = [self._face_distances(part) for part in (intervals.begin, intervals.end)]
        # Distances beyond both faces along each axis of the box.
        is_outside = (np.minimum(*face_distances) > intervals.deviations[0][:, None]).any(axis=1)
        speeds = np.stack([_norms(part.velocity) for part in (intervals.begin, intervals.end)])
        is_inside = np.stack([(away <= 0).all(axis=1) for away in face_distances])
        upper = np.where(is_outside, 0.0, speeds.max(axis=0) + intervals.deviations[1])
        return upper, np.where(is_inside, speeds, 0.0)

    def _face_distances(self, part: FrameMotion) -> Array:
        """Return the distances of positions beyond each face [m], shape (n, 6)."""
        local = (part.position - self.p_wb) @ self.R_WB
        return np.concatenate([local - self.half_size, -local - self.half_size], axis=1)


def _zone_quantity(model: DrakeModel, request: CertifyRequest, zone: SpeedZone) -> _SpeedInBox:
    X_WR = FramePoses(model, request, zone.box.reference).at_reference()
    return _SpeedInBox(
        f"speed_zone {zone.name}",
        zone.speed,
        X_WR[:3, :3] @ rotation.matrix(zone.box.pose.quaternion),
        X_WR[:3, :3] @ zone.box.pose.position + X_WR[:3, 3],
        zone.box.size / 2,
    )


def _norms(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=1)
