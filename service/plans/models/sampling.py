"""How to sample the trajectory that is delivered."""

from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field, Strict, model_validator

from planning.domain.curves import sampling as domain
from planning.domain.curves.curve import TimedTrajectory
from planning.errors import ProblemInvalid
from service.api.models import WHOLE, Boolean, Real, RequestModel

# Between samples [s].
DEFAULT_PERIOD = 0.01
MAX_SAMPLES = 200_000
# Where requests say how to sample: fields of a body, deep in it or not, or parameters of a query.
IN_BODY = ("retime.sample_period", "retime.num_points")
IN_QUESTION = ("sample_period", "num_points")
IN_QUERY = ("period", "points")


class Sampling(RequestModel):
    """A number of samples, or a longest time between two."""

    sample_period: Annotated[Real, Field(ge=1e-4, le=10)] | None = Field(
        default=DEFAULT_PERIOD,
        description="Longest time between delivered samples [s]; null where `num_points` "
        "says how many; more than 200000 samples are `problem_invalid`. They "
        "lie where the pieces of the motion meet, and evenly between, so that "
        "every interpolation of them can be proven",
    )
    even_samples: Boolean = Field(
        default=False,
        description="Whether to deliver samples exactly `sample_period` apart, but for "
        "the last, wherever the pieces of the motion meet; "
        "`trajectory.interpolations` says what is proven of them",
    )
    num_points: Annotated[int, Strict(), Field(ge=2, le=200_000), WHOLE] | None = Field(
        default=None,
        description="Number of samples to deliver, evenly in time however far apart, "
        "first and last instants included; null for one every "
        "`sample_period`, not both. `trajectory.interpolations` says what is "
        "proven of them",
    )

    @model_validator(mode="before")
    @classmethod
    def _know_no_period_of_points(cls, given: Any) -> Any:
        """Drop the default where a number of points is given; to give both is refused later."""
        if isinstance(given, dict) and given.get("num_points") is not None:
            return {"sample_period": None, **given}
        return given

    @property
    def sampling(self) -> domain.Sampling:
        """At which instants to sample."""
        period = self.sample_period or DEFAULT_PERIOD
        return domain.Sampling(period, self.num_points, self.even_samples)

    def sampling_with(
        self, period: float | None, num_points: int | None, *, even: bool
    ) -> domain.Sampling:
        """Return at which instants to sample if a query asks for something else, or for nothing.

        Raises:
            ProblemInvalid: It asks for a period and for a number of points.
        """
        require_one_sampling(period, num_points, IN_QUERY)
        own = self.sampling
        if period is None and num_points is None:
            return replace(own, is_even=even or own.is_even)
        return domain.Sampling(period or own.period, num_points, even)


def require_one_sampling(
    period: float | None, num_points: int | None, names: tuple[str, str] = IN_BODY
) -> None:
    """Go on only if a request does not say twice how to sample.

    Args:
        period: Between samples [s]; None if it is not given.
        num_points: How many samples; None if it is not given.
        names: What the request calls these two.

    Raises:
        ProblemInvalid: Both are given.
    """
    if period is not None and num_points is not None:
        message = f"`{names[0]}` and `{names[1]}` cannot both be given: one follows from the other"
        raise ProblemInvalid(message, {"field": names[1]})


def require_few(
    trajectory: TimedTrajectory, sampling: domain.Sampling, names: tuple[str, str] = IN_BODY
) -> None:
    """Go on only if a motion has not too many samples.

    Args:
        trajectory: What to sample.
        sampling: At which instants.
        names: What the request calls the period and the number of points.

    Raises:
        ProblemInvalid: That would be too many samples.
    """
    count = sampling.num_points or trajectory.duration / sampling.period
    if count > MAX_SAMPLES:
        message = (
            f"{names[0]}: a motion of {trajectory.duration:.4g} s with a sample every "
            f"{sampling.period:g} s would have more than {MAX_SAMPLES} samples; take a longer one, "
            f"or `{names[1]}`"
        )
        raise ProblemInvalid(message, {"field": names[0], "bound": MAX_SAMPLES})
