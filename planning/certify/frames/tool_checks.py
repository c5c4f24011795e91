"""Tool checks: speed and acceleration limits of frames, everywhere and in speed zones."""

from dataclasses import dataclass

import numpy as np

from planning.certify.frames.frame_poses import FramePoses
from planning.certify.frames.frame_proof import FrameProof, FrameQuantity, Spans
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
                quantity = _Rate(f"{_NAMES[order]} {limit.frame}", rate, order)
                by_frame.setdefault(limit.frame, []).append(quantity)
    for zone in request.speed_zones:
        by_frame.setdefault(zone.frame, []).append(_zone(model, request, zone))
    return [
        check
        for frame, quantities in by_frame.items()
        for check in FrameProof(model, request, frame, quantities).run(deadline)
    ]


@dataclass(frozen=True)
class _Rate:
    """Norm of the origin's velocity (order 1) or acceleration (order 2)."""

    name: str
    limit: float
    order: int

    @property
    def unit(self) -> str:
        return _UNITS[self.order]

    def look(self, spans: Spans) -> tuple[Array, Array]:
        seen = np.stack([_length(self._of(part)) for part in (spans.begin, spans.end)])
        return seen.max(axis=0) + spans.strays[self.order], seen

    def _of(self, part: FrameMotion) -> Array:
        return part.velocity if self.order == 1 else part.acceleration


@dataclass(frozen=True)
class _SpeedInBox:
    """Norm of the origin's velocity inside a box (speed zone)."""

    name: str
    limit: float
    R_WB: Array
    p_wb: Array
    half: Array
    unit: str = "m/s"

    def look(self, spans: Spans) -> tuple[Array, Array]:
        beyond = [self._beyond(part) for part in (spans.begin, spans.end)]
        # Distances beyond both faces along each axis of the box.
        is_outside = (np.minimum(*beyond) > spans.strays[0][:, None]).any(axis=1)
        speeds = np.stack([_length(part.velocity) for part in (spans.begin, spans.end)])
        is_inside = np.stack([(away <= 0).all(axis=1) for away in beyond])
        upper = np.where(is_outside, 0.0, speeds.max(axis=0) + spans.strays[1])
        return upper, np.where(is_inside, speeds, 0.0)

    def _beyond(self, part: FrameMotion) -> Array:
        """Return the distances of positions beyond each face [m], shape (n, 6)."""
        local = (part.position - self.p_wb) @ self.R_WB
        return np.concatenate([local - self.half, -local - self.half], axis=1)


def _zone(model: DrakeModel, request: CertifyRequest, zone: SpeedZone) -> _SpeedInBox:
    X_WR = FramePoses(model, request, zone.box.reference).at_reference()
    return _SpeedInBox(
        f"speed_zone {zone.name}",
        zone.speed,
        X_WR[:3, :3] @ rotation.matrix(zone.box.pose.quaternion),
        X_WR[:3, :3] @ zone.box.pose.position + X_WR[:3, 3],
        zone.box.size / 2,
    )


def _length(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=1)
