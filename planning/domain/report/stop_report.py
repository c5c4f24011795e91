"""StopReport: how long and how far a motion goes on when it is stopped at the worst instant."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class StopReport(Value):
    """Stops along the path, from every instant, within limits; guaranteed upper bounds.

    Attributes:
        time: Of the longest stop [s].
        begin: When it begins [s].
        distance: The longest way of a joint, or of a block of them, until it stands [rad or m].
        joint: Which one.
        tool_distance: The longest way of the tool frame's origin until it stands [m]; None if the
            group has no tool frame.
        frame: The tool frame, or "".
        unheld: What is over its limit where the motion stands still, "torque" and the joint, so
            that no stop ends there; "" if none is.
        unheld_at: When the motion is where that is worst [s]; None if it is nowhere.
    """

    time: float
    begin: float
    distance: float
    joint: str
    tool_distance: float | None
    frame: str
    unheld: str = ""
    unheld_at: float | None = None
