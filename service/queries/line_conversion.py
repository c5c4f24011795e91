"""Lines: from the wire to the domain and back."""

from typing import Any

from planning.api.trace_line import TraceResolution
from planning.domain.goals.line_trace import LineStop, LineTrace
from service.api.models import listed
from service.plans.models.goal_values import pose_wire
from service.queries.models.line import LineRequest
from service.queries.verdict_conversion import pair_wire


def fineness_value(request: LineRequest) -> TraceResolution:
    """Return how closely a line shall be followed."""
    return TraceResolution(request.deviation.position, request.deviation.rotation, request.max_step)


def trace_wire(trace: LineTrace, *, with_poses: bool) -> dict[str, Any]:
    """Return the answer to a line request."""
    poses = [pose_wire(trace.line.pose(s)) for s in trace.fractions] if with_poses else None
    return {
        "fraction": trace.fraction,
        "length": trace.length,
        "fractions": listed(trace.fractions),
        "positions": listed(trace.positions),
        "poses": poses,
        "deviation": {
            "position": trace.max_position_deviation,
            "rotation": trace.max_rotation_deviation,
        },
        "stopped_by": None if trace.stop is None else _stop_wire(trace.stop),
    }


def _stop_wire(stop: LineStop) -> dict[str, Any]:
    return {
        "reason": stop.reason,
        "fraction": stop.fraction,
        "where": pose_wire(stop.where),
        "positions": listed(stop.positions),
        "joint": stop.joint or None,
        "pair": None if stop.pair is None else pair_wire(stop.pair),
        "singular_value": stop.singular_value,
    }
