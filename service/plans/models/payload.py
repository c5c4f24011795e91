"""Payload: what a robot carries that the scene does not show."""

from typing import Annotated, Any, Self

from pydantic import ConfigDict, Field, model_validator

import planning
from planning.errors import ProblemInvalid
from service.api.models import Coordinate, Name, Real, RequestModel, Triple

type Moments = Annotated[list[Coordinate], Field(min_length=6, max_length=6)]

EXAMPLE: dict[str, Any] = {"frame": "arm::tool0", "mass": 2.0, "center_of_mass": [0, 0, 0.05]}


class Payload(RequestModel):
    """A rigid mass that follows a frame and burdens every joint that carries it."""

    model_config = ConfigDict(title="Payload", json_schema_extra={"examples": [EXAMPLE]})

    frame: Name = Field(description="What it follows; the group must move it")
    mass: Annotated[Real, Field(gt=0, le=1e4)] = Field(description="[kg]")
    center_of_mass: Triple = Field(default=[0.0, 0.0, 0.0], description="In the frame [m]")
    inertia: Moments = Field(
        default=[0.0] * 6,
        description="Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the centre of mass, along the frame's axes "
        "[kg m^2]; zeros for a point mass",
    )

    @model_validator(mode="after")
    def _could_be_a_body(self) -> Self:
        try:
            self.value()
        except ProblemInvalid as fault:
            raise ValueError(fault.detail) from fault
        return self

    def value(self) -> planning.Payload:
        """Return the domain's payload."""
        return planning.Payload.from_parts(self.frame, self.mass, self.center_of_mass, self.inertia)
