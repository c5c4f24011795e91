"""BesideReport: whether a motion may be executed beside others, at any times of all of them."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from planning.domain.value import Value


class BesideOutcome(StrEnum):
    """Outcomes of the proof for two motions; only the first permits their execution."""

    PROVEN = "proven"
    VIOLATED = "violated"
    UNDECIDED = "undecided"


@dataclass(frozen=True, eq=False)
class BesideCheck(Value):
    """Check that a motion keeps its margins beside one other motion, at any times of both.

    Attributes:
        group: Group of the other motion.
        outcome: "proven": at every instant of the motion and every instant of the other, all
            pairs keep their margins. "violated": at `time` and `other_time` the pair does not.
            "undecided": the bounds did not suffice to prove the pair near these instants.
        pair: A body moved by the motion, and one moved by the other; of a proof, the pair with the
            smallest reserve of those measured; ("", "") if no body of one may meet one of the
            other.
        distance: Their signed distance at these instants [m]; infinite without a pair. It is an
            upper bound on the smallest distance, not the smallest distance.
        margin: Their margin [m].
        time: Instant of the motion [s].
        other_time: Instant of the other motion [s].
        num_segments: Number of pairs of segments bounded.
    """

    group: str
    outcome: BesideOutcome
    pair: tuple[str, str] = ("", "")
    distance: float = np.inf
    margin: float = 0.0
    time: float = 0.0
    other_time: float = 0.0
    num_segments: int = 0

    @property
    def passed(self) -> bool:
        """Whether the margins are proven."""
        return self.outcome is BesideOutcome.PROVEN


@dataclass(frozen=True, eq=False)
class BesideReport(Value):
    """Whether a motion keeps its margins beside others, whatever the timing of each.

    Not promised: anything about pairs of which the motion moves no body, or both, or of which no
    other motion moves one (their own certificates are about these), about joints outside of all
    groups that do not stay where the scene has them, or about tracking errors.

    Attributes:
        checks: A check for each other motion in the order given, up to the first that failed.
    """

    checks: tuple[BesideCheck, ...]

    @property
    def proven(self) -> bool:
        """Whether the motion is proven beside all of the others."""
        return all(check.passed for check in self.checks)

    @property
    def failed(self) -> BesideCheck | None:
        """The check that failed; None if the motion is proven."""
        return next((check for check in self.checks if not check.passed), None)
