"""How to sample the trajectory that is delivered."""

from typing import Annotated, Any

from pydantic import Field, Strict, model_validator

from service.schemas.numbers import WHOLE, Real
from service.schemas.wire import Wire

# Between samples [s].
DEFAULT_PERIOD = 0.01


class SamplingWire(Wire):
    """So many samples, or one every so often."""

    sample_period: Annotated[Real, Field(ge=1e-4, le=10)] | None = Field(
        default=DEFAULT_PERIOD,
        description="Of the delivered samples [s]; 200000 at most, more are `problem_invalid`; "
        "null where `num_points` says how many",
    )
    num_points: Annotated[int, Strict(), Field(ge=2, le=200_000), WHOLE] | None = Field(
        default=None,
        description="Deliver so many samples, evenly in time, first and last instants included; "
        "null for one every `sample_period`; not both",
    )

    @model_validator(mode="before")
    @classmethod
    def _know_no_period_of_points(cls, given: Any) -> Any:
        """Let the default go where a number of points stands: whoever gives both is refused."""
        if isinstance(given, dict) and given.get("num_points") is not None:
            return {"sample_period": None, **given}
        return given

    @property
    def period(self) -> float:
        """Between samples [s], where `num_points` does not say how many there are."""
        return self.sample_period or DEFAULT_PERIOD
