"""DrakeTerm: costs and constraints of a library user, in Drake's own language."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class DrakeTerm(Value):
    """Costs and constraints that a function adds to Drake's trajectory optimization.

    The function is called with a `pydrake.planning.KinematicTrajectoryOptimization` over the
    positions of the problem's group, and with the scene's finalized `MultibodyPlant`, whose
    positions are those of all joints of the scene. It is called several times, for programs of the
    same size, and must add the same each time.

    Its constraints are also evaluated on the motion that is delivered, by the certifier: at the
    instants at which the function has put them and nowhere else, which the check says. A problem
    with a term has no digest, and it pickles only if the function does.

    Attributes:
        add: Adds to the program; what it returns is ignored.
        name: Name of the term in messages and in the certificate.
    """

    add: Callable[[Any, Any], object]
    name: str = "term"
