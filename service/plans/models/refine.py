"""Refine: whether and how to optimise the path, and by which objective."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from planning.domain.request import options as domain
from planning.domain.request.refine_objective import MAX_DURATION, MAX_WEIGHT
from planning.domain.request.refine_objective import RefineObjective as DomainObjective
from service.api.fingerprint import ADDED
from service.api.models import Real, RequestModel

Weight = Annotated[Real, Field(ge=0, le=MAX_WEIGHT)]


class ClearanceObjective(RequestModel):
    """Clearance that is preferred, beyond the margin that is required."""

    distance: Annotated[Real, Field(gt=0, le=1)] = Field(
        description="Preferred distance between bodies, except between those of one robot [m]"
    )
    weight: Annotated[Real, Field(gt=0, le=1e4)] = Field(
        description="Extra duration that one metre less of shortfall is worth [s/m]; the "
        "shortfall is what the clearance lacks of `distance`, on average "
        "along the motion"
    )

    def to_domain(self) -> domain.ClearanceObjective:
        """Return the domain's objective."""
        return domain.ClearanceObjective(self.distance, self.weight)


class RefineObjective(RequestModel):
    """Objective to minimise: a weighted sum; at least one weight is positive."""

    duration: Weight = Field(default=0.0, description="Weight of the duration [1/s]")
    smoothness: Weight = Field(
        default=0.0,
        description="Weight of the integral over time of the squared norm of what `derivative` "
        "names [s^3/rad^2, for jerk s^5/rad^2]",
    )
    energy: Weight = Field(
        default=0.0,
        description="Weight of the integral over time of the squared norm of the joints' torques "
        "and forces, gravity, damping and payload included [1/(N^2 m^2 s)]; not for groups with a "
        "floating joint",
    )
    path_length: Weight = Field(
        default=0.0, description="Weight of the joint-space length [1/rad or 1/m]"
    )
    derivative: Literal["acceleration", "jerk"] = Field(
        default="acceleration", description="Derivative that smoothness integrates"
    )
    max_duration: Annotated[Real, Field(gt=0, le=MAX_DURATION)] | None = Field(
        default=None,
        description="Longest duration of the motion [s], approach and retreat not "
        "counted; less than the limits allow is `retiming_failed`. Smoothness "
        "and energy need it unless the duration has a weight",
    )

    def to_domain(self) -> DomainObjective:
        """Return the domain's objective."""
        return DomainObjective(
            self.duration,
            self.smoothness,
            self.energy,
            self.path_length,
            self.derivative,
            self.max_duration,
        )


class Refine(RequestModel):
    """Options for optimising the path."""

    method: Literal["trajopt", "drake", "auto", "none"] = Field(
        default="trajopt",
        description="Method: convex steps (`trajopt`), Drake's "
        "KinematicTrajectoryOptimization (`drake`), as `trajopt` but only if "
        "at least half a second is left (`auto`), or none, which leaves the "
        "path as it is",
    )
    clearance: ClearanceObjective | None = Field(
        default=None,
        description="Clearance that the duration is weighed against; `none` and `drake` "
        "have no use for it",
    )
    objective: Annotated[RefineObjective | None, ADDED] = Field(
        default=None,
        description="Objective to minimise; null for the duration, the only objective for "
        "cars. With it, or with `drake`, the report has all objectives, "
        "before and after",
    )

    @model_validator(mode="after")
    def _has_use(self) -> Self:
        if self.clearance is not None and self.method in {"none", "drake"}:
            message = f"clearance requires method 'trajopt' or 'auto', not {self.method!r}"
            raise ValueError(message)
        if self.objective is not None:
            fault = self.objective.to_domain().fault_with(self.method)
            if not fault and self.clearance is not None:
                fault = "objective and clearance exclude each other"
            if fault:
                raise ValueError(fault)
        return self

    def to_domain(self) -> domain.RefineOptions:
        """Return the domain's options of the refinement."""
        return domain.RefineOptions(
            self.method,
            self.clearance and self.clearance.to_domain(),
            self.objective and self.objective.to_domain(),
        )
