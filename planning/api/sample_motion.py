"""sample_motion(): samples of a certified motion, and proofs for interpolations of the samples."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planning.api.certify_trajectory import validate_joints
from planning.certify.intervals.hermite_errors import HermiteErrors
from planning.certify.request import CertifyRequest
from planning.certify.samples.interpolants import KINDS, prove_interpolants
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.interpolation_proof import InterpolationProof
from planning.domain.curves.sampling import SampledTrajectory, Sampling, sample_trajectory
from planning.domain.report.motion_plan import PlanPart
from planning.domain.request.constraint import PathConstraint
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RetimeOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.value import Value
from planning.pipeline.certification import certify_request
from planning.pipeline.line_sections import line_sections
from planning.pipeline.timing.timing_options import resolve_retiming
from planning.search.space_options import resolve_space
from planning.world.constraints.validate_constraints import validate_constraints
from planning.world.world import World


@dataclass(frozen=True, eq=False)
class ProvenSamples(Value):
    """Samples of a motion, and proofs for the motions that controllers interpolate from them.

    Attributes:
        samples: Samples of the motion.
        interpolations: Result of the proof of each interpolation.
    """

    samples: SampledTrajectory
    interpolations: tuple[InterpolationProof, ...]


def sample_motion(  # noqa: PLR0913  (all inputs of a request)
    world: World,
    group: str,
    trajectory: TimedTrajectory,
    sampling: Sampling,
    *,
    deadline: Deadline,
    options: RetimeOptions | None = None,
    clearance: float = -np.inf,
    margin: float | None = None,
    constraints: tuple[PathConstraint, ...] = (),
    origin: Any = None,
) -> ProvenSamples:
    """Return samples of a certified motion, and whether each interpolation of them is proven.

    Args:
        world: Loaded scene.
        group: Joint group that moves, `robot` or `robot::group`.
        trajectory: The motion.
        sampling: Instants of the samples.
        deadline: Time limit of the proofs; interpolations not proven by then count as not proven.
        options: Limits of the certified motion; jerk is limited if `method` is "ruckig". None for
            the defaults.
        clearance: Lower bound on all distances along the motion, from its certificate [m]; unknown
            by default, which takes longer.
        margin: Required distance of bodies [m]; None for the scene's.
        constraints: Path constraints of the motion.
        origin: First configuration of the running motion that this one continues, shape (nq,); None
            if it begins at rest.

    Raises:
        UnknownName: There is no such group, body, frame or joint.
        ProblemInvalid: The trajectory is of other joints, or a limit is invalid.
        Canceled: Cancellation was requested.
    """
    joints = world.group(group)
    validate_joints(joints, trajectory, "trajectory")
    validate_constraints(world, joints, constraints)
    begin = trajectory.start if origin is None else origin
    timing = resolve_retiming(world, joints, options or RetimeOptions(), begin, field_prefix="")
    request = replace(
        certify_request(world, joints, trajectory, timing, world.margins(margin)),
        constraints=constraints,
        origin=origin,
    )
    return _sample(world, request, sampling, clearance, deadline)


def sample_plan(  # noqa: PLR0913  (all inputs of a request)
    world: World,
    problem: PlanningProblem,
    trajectory: TimedTrajectory,
    parts: Sequence[PlanPart],
    sampling: Sampling,
    *,
    deadline: Deadline,
    clearance: float = -np.inf,
) -> ProvenSamples:
    """Return proven samples, as `sample_motion` does, of a plan's motion, possibly slowed down.

    Args:
        world: Loaded scene.
        problem: Problem that the motion solves.
        trajectory: The motion.
        parts: Segments of the motion.
        sampling: Instants of the samples.
        deadline: Time limit of the proofs; interpolations not proven by then count as not proven.
        clearance: Lower bound on all distances along the motion, from its certificate [m]; unknown
            by default, which takes longer.

    Raises:
        UnknownName: The scene has no such group.
        ProblemInvalid: The problem's cars or limits are invalid in this scene, or the trajectory is
            of other joints.
        Canceled: Cancellation was requested.
    """
    group = resolve_space(world.group(problem.group), problem.search.spaces)
    validate_joints(group, trajectory, "trajectory")
    options = resolve_retiming(world, group, problem.retime, trajectory.start)
    request = replace(
        certify_request(world, group, trajectory, options, world.margins(problem.margin)),
        constraints=problem.constraints,
        lines=line_sections(world, group, problem, trajectory, parts),
        options=problem.certify,
    )
    return _sample(world, request, sampling, clearance, deadline)


def _sample(
    world: World,
    original_request: CertifyRequest,
    sampling: Sampling,
    clearance: float,
    deadline: Deadline,
) -> ProvenSamples:
    # The group's own joint objects, so that comparisons by identity suffice.
    trajectory = replace(original_request.trajectory, joints=original_request.group.joints)
    request = replace(original_request, trajectory=trajectory)
    limits = request.limits.per_coordinate(request.limits.acceleration)
    errors = HermiteErrors.of(request)
    gaps = None if errors is None else errors.sample_spacing("quintic")
    samples = sample_trajectory(trajectory, sampling, limits, gaps)
    proofs = prove_interpolants(world.drake, request, samples, clearance, deadline, errors)
    return ProvenSamples(samples, proofs)


def unproven_samples(trajectory: TimedTrajectory, sampling: Sampling, reason: str) -> ProvenSamples:
    """Return samples without proofs, for the given reason, where there is no scene."""
    unlimited = np.full(trajectory.manifold.num_velocities, np.inf)
    proofs = tuple(
        InterpolationProof(kind, proven=False, deviation=np.inf, up_to_period=None, reason=reason)
        for kind in KINDS
    )
    return ProvenSamples(sample_trajectory(trajectory, sampling, unlimited), proofs)
