"""ConfigurationQuality: manipulability, clearance and limit margin of one configuration."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class ArmBranch(Value):
    """Arm configuration branch (shoulder, elbow, wrist) of a six-joint arm.

    Each is 1 or -1, or 0 at that singularity.

    Attributes:
        shoulder: Side of the first axis on which the wrist is.
        elbow: Side to which the elbow bends.
        wrist: Side to which the wrist bends.
    """

    shoulder: int
    elbow: int
    wrist: int


@dataclass(frozen=True, eq=False)
class ConfigurationQuality(Value):
    """Quality measures of one configuration of a group.

    Attributes:
        manipulability: Product of the singular values of the tool's Jacobian (Yoshikawa); it
            compares configurations of one arm.
        clearance: Smallest signed distance of any two bodies [m]; None if nothing can collide.
        pair: The full names of these two.
        limit_margin: Smallest distance to a position limit as a share of its range, 0 to 0.5; None
            if no coordinate is limited.
        distance: From the start, by the weighted joint metric [rad or m].
        branch: Of a six-joint arm with a spherical wrist or one like Universal Robots'; else None.
    """

    manipulability: float
    clearance: float | None
    pair: tuple[str, str] | None
    limit_margin: float | None
    distance: float
    branch: ArmBranch | None
