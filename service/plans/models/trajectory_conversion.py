"""Trajectories: sampled in JSON, and exactly there and back."""

from collections.abc import Sequence
from typing import Any

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation_proof import InterpolationProof
from planning.domain.curves.sampling import SampledTrajectory
from service.plans.models.sampling import (
    IN_BODY,
    IN_QUERY,
    IN_QUESTION,
    MAX_SAMPLES,
    require_few,
    require_one_sampling,
)
from service.plans.models.trajectory import Polynomial, Trajectory

__all__ = [
    "IN_BODY",
    "IN_QUERY",
    "IN_QUESTION",
    "MAX_SAMPLES",
    "polynomial_wire",
    "require_few",
    "require_one_sampling",
    "sampled_wire",
    "trajectory_value",
]


def sampled_wire(
    samples: SampledTrajectory, interpolations: Sequence[InterpolationProof]
) -> dict[str, Any]:
    """Return the samples of a trajectory, and what is proven of them."""
    return Trajectory.from_samples(samples, interpolations).model_dump()


def polynomial_wire(trajectory: TimedTrajectory) -> dict[str, Any]:
    """Return the exact trajectory."""
    return Polynomial.from_domain(trajectory).model_dump()


def trajectory_value(polynomial: dict[str, Any]) -> TimedTrajectory:
    """Return the trajectory that `polynomial_wire` wrote."""
    return Polynomial.model_validate(polynomial).to_domain()
