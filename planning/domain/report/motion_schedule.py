"""MotionSchedule: when several motions begin, who waits for whom, and the proof of all together."""

from dataclasses import dataclass

from planning.domain.report.certificate import Certificate
from planning.domain.report.stage_reports import CertifyReport
from planning.domain.request.group_motion import CombinedMotion
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Wait(Value):
    """Wait of a motion for another one.

    Attributes:
        group: Group of the motion that waits.
        for_group: Group of the motion that it waits for: begun earlier, it would meet this one.
        delay: How long it waits, from the beginning of the schedule [s].
        pair: The two bodies that would come nearer than their margin.
        time: Instant of the schedule at which they would, if it began a little earlier [s].
    """

    group: str
    for_group: str
    delay: float
    pair: tuple[str, str]
    time: float


@dataclass(frozen=True, eq=False)
class MotionSchedule(Value):
    """Proven schedule of several motions.

    Attributes:
        groups: Groups of the motions, in the order given.
        delays: When each begins, from the beginning of the schedule [s].
        waits: Each motion that waits, in the order given.
        motion: All motions as one, which the certificate is about.
        certificate: The proof of it, with all groups moving.
        report: The certifier's report.
    """

    groups: tuple[str, ...]
    delays: tuple[float, ...]
    waits: tuple[Wait, ...]
    motion: CombinedMotion
    certificate: Certificate
    report: CertifyReport

    @property
    def duration(self) -> float:
        """From the beginning of the first motion to the end of the last [s]."""
        return self.motion.trajectory.duration
