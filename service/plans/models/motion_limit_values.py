"""Limits on a motion besides those of its joints: from JSON to the domain."""

from service.plans.models.motion_limits import LimitFields, ScaledLimits


def motion_limits(limits: ScaledLimits) -> LimitFields:
    """Return the limits, and the scales, as fields of the options of the timing."""
    return limits.limit_fields()
