"""Asking how far a tool can be moved in a straight line, and what stops it."""

from typing import Annotated, Self

from pydantic import ConfigDict, Field

from planning.domain.goals import line_trace as domain
from service.api.models import (
    GROUP,
    Boolean,
    GroupName,
    GroupPositions,
    LineStopReason,
    NonNegative,
    Pose,
    Real,
    ResponseModel,
    listed,
)
from service.plans.models.line_goals import Deviation, LineTarget, ToolFrame
from service.scenes.models.pairs import Pair


class FoundDeviation(ResponseModel):
    """Largest deviation of a tool from its line that was found, between waypoints too."""

    position: float = Field(description="Distance of the tool's origin from the line [m]")
    rotation: float = Field(
        description="Angle between the tool's rotation and that of the line [rad]"
    )


class LineRequest(LineTarget):
    """Move a tool in a straight line, as far as it goes."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"group": "arm", "displacement": {"vector": [0, 0, 0.1], "frame": "arm::tcp"}}
            ]
        }
    )

    group: GroupName = Field(description=GROUP)
    start: GroupPositions | None = Field(
        default=None,
        description="Positions of the group at first [rad or m]; null for the scene's state",
    )
    frame: ToolFrame = None
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that everything keeps [m]; null for the scene's"
    )
    max_step: Annotated[Real, Field(ge=1e-4, le=10)] = Field(
        default=0.05, description="Largest distance that the tool moves between waypoints [m]"
    )
    deviation: Deviation = Field(
        default_factory=Deviation,
        description="Largest deviation from the line of the straight ways between the waypoints",
    )
    poses: Boolean = Field(default=False, description="Whether to answer the tool's poses as well")
    allowed_time: Annotated[Real, Field(gt=0, le=60)] = Field(
        default=5.0, description="Time after which to give up [s]"
    )


class LineStop(ResponseModel):
    """Place and reason of a line's stop before its end."""

    reason: LineStopReason = Field(
        description="Reason of the stop: a joint would leave its range (`limit`), two "
        "bodies would be nearer than their margin (`collision`), the joints "
        "would have to move without bound (`singularity`), or they cannot "
        "move the tool that way (`unreachable`)"
    )
    fraction: float = Field(description="Share of the line that was reached, to about 1e-5 [1]")
    where: Pose = Field(description="Pose of the tool there, in world")
    positions: list[float] = Field(description="Positions of the group there [rad or m]")
    joint: str | None = Field(description="The position coordinate at its limit, for `limit`")
    pair: Pair | None = Field(description="The two bodies just beyond, for `collision`")
    singular_value: float = Field(
        description="Smallest singular value there of the tool's Jacobian, of those that are not "
        "zero everywhere [1 or m per rad or m]"
    )

    @classmethod
    def from_domain(cls, stop: domain.LineStop) -> Self:
        """Return a stop."""
        return cls(
            reason=stop.reason,
            fraction=stop.fraction,
            where=Pose.from_domain(stop.where),
            positions=listed(stop.positions),
            joint=stop.joint or None,
            pair=None if stop.pair is None else Pair.from_domain(stop.pair),
            singular_value=stop.singular_value,
        )


class LineResponse(ResponseModel):
    """Waypoints along the free part of the line, its length, and what stops it."""

    fraction: float = Field(description="Share of the line that is reached, 0 to 1 [1]", ge=0, le=1)
    length: float = Field(description="Distance that the tool's origin gets along the line [m]")
    fractions: list[float] = Field(description="Share of the line at every waypoint [1]")
    positions: list[list[float]] = Field(
        description="Waypoints from the start on, to be joined straight [rad or m]"
    )
    poses: list[Pose] | None = Field(
        description="Pose of the tool at each waypoint, in world; null if not asked for"
    )
    deviation: FoundDeviation = Field(
        description="Largest deviation of the tool from the line, between waypoints too"
    )
    stopped_by: LineStop | None = Field(
        description="Reason why the line stops; null if all is reached"
    )

    @classmethod
    def from_domain(cls, trace: domain.LineTrace, *, with_poses: bool) -> Self:
        """Return a line that was traced."""
        poses = (Pose.from_domain(trace.line.pose(s)) for s in trace.fractions)
        return cls(
            fraction=trace.fraction,
            length=trace.length,
            fractions=listed(trace.fractions),
            positions=listed(trace.positions),
            poses=list(poses) if with_poses else None,
            deviation=FoundDeviation(
                position=trace.max_position_deviation, rotation=trace.max_rotation_deviation
            ),
            stopped_by=None if trace.stop is None else LineStop.from_domain(trace.stop),
        )
