"""RestReport: whether what is left of a motion keeps its margins, and until when it does."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class RestReport(Value):
    """Whether the rest of a motion keeps its margins. Its times are those of the whole motion.

    Attributes:
        proven: All pairs of bodies keep their margins from `since` to the motion's end.
        since: Instant at which the rest begins [s].
        proven_until: The margins are proven from `since` until then [s]: the motion's duration if
            they are proven; else the first instant that is not, less a millisecond at most.
        pair: The two bodies that are not proven to keep their margin then; ("", "") if all are, or
            if the time ran out before the pair was known.
        distance: Their signed distance at that instant, where it was measured [m]; infinite if it
            was not.
    """

    proven: bool
    since: float
    proven_until: float
    pair: tuple[str, str]
    distance: float
