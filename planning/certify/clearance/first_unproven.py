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
_FINE = 1e-4
_SEGMENT = 1e-7


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
    search = _Search(model, request, deadline)
    with suppress(DeadlineExceeded):
        search.run()
    return replace(certificate, proven_until=search.proven, first_unproven=search.pair())


class _Search:
    """Bisection between the latest proven and the earliest refused end of an initial part.

    Attributes:
        proven: End of the longest proven part [s].
        refused: End of the shortest refused part [s].
    """

    def __init__(self, model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> None:
        self._model, self._request, self._deadline = model, request, deadline
        self.proven, self.refused = 0.0, request.trajectory.duration
        self._spot = WitnessPoint()

    def run(self) -> None:
        """Bisect until the instant is known to the resolution.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The caller canceled.
        """
        self._prove_until(self.refused)
        while self.refused - self.proven > _FINE:
            self._prove_until((self.proven + self.refused) / 2)

    def _prove_until(self, end: float) -> None:
        self._deadline.check("certify")
        begin = self.proven
        part = self._request.trajectory.until(end).after(begin)
        found = quick_clearance(
            self._model, replace(self._request, trajectory=part), self._deadline
        )
        if found.check.passed:
            self.proven = end
            return
        self._spot = replace(found.checked, time=min(begin + found.checked.time, end))
        self.refused = min(self._spot.time + _SEGMENT, end)

    def pair(self) -> BodyPair | None:
        """Return the pair of bodies that refused the last refused part; None if there is none."""
        spot = self._spot
        if not spot.shapes:
            return None
        points, distance = nearest_points(self._model, self._request, spot)
        return BodyPair(spot.bodies, distance, points)
