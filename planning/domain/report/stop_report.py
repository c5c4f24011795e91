"""StopReport: bounds on the time and distance of a stop along the path from the worst instant."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class StopReport(Value):
    """Stops along the path, from every instant, within limits; guaranteed upper bounds.

    Attributes:
        time: Of the longest stop [s].
        begin: Beginning of that stop [s].
        distance: Longest stopping distance of a joint, or of a block of joints [rad or m].
        joint: The joint or block of `distance`.
        tool_distance: Longest stopping distance of the tool frame's origin [m]; None if the
            group has no tool frame.
        frame: The tool frame, or "".
        unheld: Limit exceeded at standstill, "torque" and the joint, so that no stop can end there;
            "" if there is none.
        unheld_at: Time at which the motion passes the worst such configuration [s]; None if none.
    """

    time: float
    begin: float
    distance: float
    joint: str
    tool_distance: float | None
    frame: str
    unheld: str = ""
    unheld_at: float | None = None
