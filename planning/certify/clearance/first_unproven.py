"""First unproven instant: the time until which the clearance of a refused motion is proven.

The proof bounds the segment with the smallest bound first, so that a bad motion is refused quickly,
at some instant. The first unproven instant is found by bisection over the end of the motion's
initial part: the part until the middle is either proven, or refused at an instant before.
"""

from contextlib import suppress
from dataclasses import replace

from planning.certify.clearance.clearance_check import quick_clearance
from planning.certify.clearance.clearance_result import WitnessPoint
from planning.certify.clearance.nearest_points import nearest_points
from planning.certify.request import CertifyRequest
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.report.certificate import Certificate
from planning.domain.request.deadline import Deadline
from planning.errors import DeadlineExceeded
from planning.world.drake_model import DrakeModel

# Resolution of the instant, and the largest delay of a reported refusal after the true one [s].
_RESOLUTION = 1e-4
_MAX_DELAY = 1e-7


def with_first_unproven(
    model: DrakeModel, request: CertifyRequest, certificate: Certificate, deadline: Deadline
) -> Certificate:
    """Return the certificate with `proven_until`, the time until which clearance is proven.

    If the time runs out, `proven_until` is the latest instant proven so far.

    Raises:
        Canceled: The caller canceled.
    """
    if all(check.name != "clearance" for check in certificate.failed):
        return certificate
    until, pair = FirstUnproven(model, request, deadline).found()
    return replace(certificate, proven_until=until, first_unproven=pair)


class FirstUnproven:
    """Bisection between the latest proven and the earliest refused end of an initial part.

    Attributes:
        proven_until: End of the longest proven part [s].
        refused_at: End of the shortest refused part [s].
    """

    def __init__(self, model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> None:
        self._model, self._request, self._deadline = model, request, deadline
        self.proven_until, self.refused_at = 0.0, request.trajectory.duration
        self._witness = WitnessPoint()

    def found(self) -> tuple[float, BodyPair | None]:
        """Return until when clearance is proven [s], and the pair at which the proof stops.

        If the time runs out, it is the latest instant proven so far.

        Raises:
            Canceled: The caller canceled.
        """
        with suppress(DeadlineExceeded):
            self._run()
        return self.proven_until, self._pair()

    def _run(self) -> None:
        """Bisect until the instant is known to the resolution.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        self._prove_until(self.refused_at)
        while self.refused_at - self.proven_until > _RESOLUTION:
            self._prove_until((self.proven_until + self.refused_at) / 2)

    def _prove_until(self, end: float) -> None:
        self._deadline.check("certify")
        begin = self.proven_until
        part = self._request.trajectory.until(end).after(begin)
        result = quick_clearance(
            self._model, replace(self._request, trajectory=part), self._deadline
        )
        if result.check.passed:
            self.proven_until = end
            return
        self._witness = replace(result.reported, time=min(begin + result.reported.time, end))
        self.refused_at = min(self._witness.time + _MAX_DELAY, end)

    def _pair(self) -> BodyPair | None:
        """Return the pair of bodies that refused the last refused part; None if there is none."""
        witness = self._witness
        if not witness.shapes:
            return None
        points, distance = nearest_points(self._model, self._request, witness)
        return BodyPair(witness.bodies, distance, points)
