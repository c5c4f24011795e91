"""ConfigurationQuality: how good a configuration is, beside being free."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class ArmBranch(Value):
    """Which of the eight ways a six-joint arm bends; 1 or -1 each, 0 at that singularity.

    Attributes:
        shoulder: On which side of the first axis the wrist is.
        elbow: To which side the elbow bends.
        wrist: To which side the wrist bends.
    """

    shoulder: int
    elbow: int
    wrist: int


@dataclass(frozen=True, eq=False)
class ConfigurationQuality(Value):
    """What there is to say of one configuration of a group.

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
