"""TouchingPair: two bodies in contact, and the force between them."""

from dataclasses import dataclass

from planning.domain.geometry.body_pair import BodyPair


@dataclass(frozen=True, eq=False)
class TouchingPair(BodyPair):
    """Two bodies in contact; `distance` is negative.

    Attributes:
        force: Magnitude of the contact force [N]; None where it is not known.
    """

    force: float | None = None
