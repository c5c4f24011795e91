"""Certification of candidate motions: the request of a motion, and the first certified one."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

from planning.certify.failure import failed_checks, not_certified
from planning.certify.request import CertifyRequest
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate
from planning.domain.report.stage_reports import CertifyReport
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointGroup
from planning.errors import NotCertified
from planning.world.collision.margins import PairMargins
from planning.world.world import World


@dataclass
class Refusals:
    """Motions that were not certified so far; the evidence of a failure.

    Attributes:
        reasons: Failed checks of each motion, one line per motion.
        last: Certificate of the last motion; None if there is none.
        trajectory: The last motion; None if there is none.
    """

    reasons: list[str] = field(default_factory=list[str])
    last: Certificate | None = None
    trajectory: TimedTrajectory | None = None

    def add(self, name: str, certificate: Certificate, trajectory: TimedTrajectory) -> None:
        """Add a motion by its name, with its failed certificate."""
        self.reasons.append(f"{name}: {failed_checks(certificate)}")
        self.last, self.trajectory = certificate, trajectory

    @property
    def failure(self) -> NotCertified:
        """Failure with all refusals as evidence."""
        return not_certified(self.last, self.reasons, self.trajectory)


def first_certified[T](
    motions: Iterable[tuple[str, T]],
    certify: Callable[[T], tuple[Certificate, CertifyReport]],
    trajectory_of: Callable[[T], TimedTrajectory],
    refusals: Refusals,
    is_hopeless: Callable[[Certificate], bool] = lambda _: False,
) -> tuple[T, Certificate, CertifyReport]:
    """Return the first motion that is proven, with its certificate and the certifier's report.

    Args:
        motions: Names and motions, best first; consumed one by one.
        certify: Certifies a motion.
        trajectory_of: Returns the trajectory of a motion, for evidence.
        refusals: Receives the motions that are not proven.
        is_hopeless: Returns whether a failed certificate rules out all other motions as well.

    Raises:
        NotCertified: None is proven, or one is hopeless; evidence has all refusals so far.
    """
    for name, motion in motions:
        certificate, report = certify(motion)
        if certificate.proven:
            return motion, certificate, report
        refusals.add(name, certificate, trajectory_of(motion))
        if is_hopeless(certificate):
            break
    raise refusals.failure


def certify_request(
    world: World,
    group: JointGroup,
    trajectory: TimedTrajectory,
    timing: RetimeOptions,
    margins: PairMargins,
    **requirements: Any,
) -> CertifyRequest:
    """Return the request to certify a motion from its own start to its own end.

    Args:
        world: Loaded scene.
        group: Joint group that moves.
        trajectory: The motion.
        timing: Limits besides the group's own, as of `resolve_retiming`; jerk is limited if
            `method` is "ruckig".
        margins: Required distance of every body pair [m].
        requirements: Fields of the request: further ones, or another start, goal or limits.
    """
    limits, followers = world.stated_limits(group)
    scales = timing.velocity_scale, timing.acceleration_scale
    fields: dict[str, Any] = {
        "group": group,
        "trajectory": trajectory,
        "state": world.state,
        "start": trajectory.start,
        "goals": trajectory.end[None],
        "limits": limits.scaled(*scales),
        "followers": tuple([follower.scaled(*scales) for follower in followers]),
        "margins": margins,
        "jerk": timing.limits_jerk,
        "tool_limits": timing.tool_limits,
        "speed_zones": timing.speed_zones,
        "acceleration_bounds": timing.acceleration_bounds,
        "effort": timing.effort,
        "payload": timing.payload,
    }
    return CertifyRequest(**{**fields, **requirements})
