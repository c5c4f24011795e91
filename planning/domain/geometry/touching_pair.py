"""TouchingPair: two bodies in contact, and the force between them."""

from collections.abc import Iterable
from dataclasses import dataclass

from planning.domain.geometry.body_pair import BodyPair


@dataclass(frozen=True, eq=False)
class TouchingPair(BodyPair):
    """Two bodies in contact; `distance` is negative.

    Attributes:
        force: Magnitude of the contact force [N]; None where it is not known.
    """

    force: float | None = None


def worst_of_each(contacts: Iterable[TouchingPair]) -> tuple[TouchingPair, ...]:
    """Return every pair once, at its deepest and with its largest force; deepest first."""
    worst: dict[tuple[str, str], TouchingPair] = {}
    for pair in contacts:
        known = worst.get(pair.bodies, pair)
        deepest = min(known, pair, key=lambda one: one.distance)
        forces = [one.force for one in (known, pair) if one.force is not None]
        worst[pair.bodies] = TouchingPair(
            pair.bodies, deepest.distance, deepest.points, max(forces, default=None)
        )
    return tuple(sorted(worst.values(), key=lambda pair: pair.distance))
