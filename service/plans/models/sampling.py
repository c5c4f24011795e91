"""How to sample the trajectory that is delivered."""

from typing import Annotated, Any

from pydantic import Field, Strict, model_validator

from planning.domain.curves import sampling as domain
from service.api.models import WHOLE, Boolean, Real, RequestModel

# Between samples [s].
DEFAULT_PERIOD = 0.01


class Sampling(RequestModel):
    """So many samples, or one every so often."""

    sample_period: Annotated[Real, Field(ge=1e-4, le=10)] | None = Field(
        default=DEFAULT_PERIOD,
        description="Longest time between delivered samples [s]: they lie where the pieces of the "
        "motion meet, and evenly between, so that every interpolation of them can be proven; "
        "200000 at most, more are `problem_invalid`; null where `num_points` says how many",
    )
    even_samples: Boolean = Field(
        default=False,
        description="Deliver samples exactly `sample_period` apart, but for the last, wherever the "
        "pieces of the motion meet; `trajectory.interpolations` says what is proven of them",
    )
    num_points: Annotated[int, Strict(), Field(ge=2, le=200_000), WHOLE] | None = Field(
        default=None,
        description="Deliver so many samples, evenly in time, first and last instants included, "
        "however far apart that is; `trajectory.interpolations` says what is proven of them; null "
        "for one every `sample_period`; not both",
    )

    @model_validator(mode="before")
    @classmethod
    def _know_no_period_of_points(cls, given: Any) -> Any:
        """Let the default go where a number of points stands: whoever gives both is refused."""
        if isinstance(given, dict) and given.get("num_points") is not None:
            return {"sample_period": None, **given}
        return given

    @property
    def sampling(self) -> domain.Sampling:
        """At which instants to sample."""
        period = self.sample_period or DEFAULT_PERIOD
        return domain.Sampling(period, self.num_points, self.even_samples)
