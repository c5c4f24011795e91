"""Where a proof of clearance stops: the earliest instant that could not be proven.

The proof looks at the most suspicious segment first, so that a bad motion is refused quickly, at
some instant. That of a part of a motion from its beginning is found by halving: the part until the
middle is proven, or it is refused at an instant before.
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

# How well the instant is found, and how much later than it is told a proof may have stopped [s].
_FINE = 1e-4
_SEGMENT = 1e-7


def with_first_unproven(
    model: DrakeModel, request: CertifyRequest, certificate: Certificate, deadline: Deadline
) -> Certificate:
    """Return a certificate that says until when clearance is proven, if it is not throughout.

    If the time runs out, `proven_until` is as late as was proven until then.

    Raises:
        Canceled: The end was asked for.
    """
    if all(check.name != "clearance" for check in certificate.failed):
        return certificate
    search = _Search(model, request, deadline)
    with suppress(DeadlineExceeded):
        search.run()
    return replace(certificate, proven_until=search.proven, first_unproven=search.pair())


class _Search:
    """Halves what lies between proven and refused.

    Attributes:
        proven: Until when clearance is [s].
        refused: Until when it is not [s].
    """

    def __init__(self, model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> None:
        self._model, self._request, self._deadline = model, request, deadline
        self.proven, self.refused = 0.0, request.trajectory.duration
        self._spot = WitnessPoint()

    def run(self) -> None:
        """Search.

        Raises:
            DeadlineExceeded: Time ran out.
            Canceled: The end was asked for.
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
        """Return the pair at which the last refused part was; None if none was refused."""
        spot = self._spot
        if not spot.shapes:
            return None
        points, distance = nearest_points(self._model, self._request, spot)
        return BodyPair(spot.bodies, distance, points)
