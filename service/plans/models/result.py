"""PlanResult: a certified motion and everything that is known of it."""

from collections.abc import Iterable
from typing import Any, Literal, Self

from pydantic import ConfigDict, Field

from planning.domain.report import certificate as domain
from planning.domain.report.motion_plan import MotionPlan
from service.api.arrays import FiniteOrNull, Row, Rows
from service.api.document.known_values import CutStage
from service.api.models import ResponseModel
from service.plans.models.checks import Check
from service.plans.models.reports import Stages
from service.plans.models.trajectory import Trajectory
from service.scenes.models.pairs import Pair, UncheckedPair


class Certificate(ResponseModel):
    """The verdict on the motion, between its samples too."""

    model_config = ConfigDict(title="Certificate")

    proven: bool = Field(description="Whether every check passed on the whole interval")
    min_clearance: FiniteOrNull = Field(
        description="Proven lower bound on the distance of all pairs at all instants [m]; "
        "`observed_clearance` if clearance is not proven; null if there is no "
        "pair"
    )
    observed_clearance: FiniteOrNull = Field(
        default=None,
        description="Smallest signed distance at any instant that was measured [m]; the true "
        "smallest one lies between `min_clearance`, if that is proven, and this",
    )
    pair: tuple[str, str] = Field(
        description="The two bodies of `observed_clearance`, or empty names"
    )
    time: float = Field(
        description="Time at which it was observed [s]. If clearance is not proven, it is "
        "neither the first instant that is too near nor for certain the worst"
    )
    points: Rows = Field(
        default=[],
        description="Nearest point of each body of `pair` at that time, in world [m]; the "
        "deepest points where they overlap, empty without a pair",
    )
    proven_until: float = Field(
        default=0.0,
        description="Clearance is proven from the beginning until then [s]: the duration, if the "
        "check `clearance` passed",
    )
    first_unproven: Pair | None = Field(
        default=None,
        description="The pair that stopped the proof of clearance there, at most 0.1 ms later; "
        "null if none did",
    )
    unchecked: list[UncheckedPair] = Field(
        default=[],
        description="Pairs of bodies whose clearance is not looked at, and why: the certificate "
        "says nothing of them",
    )
    checks: list[Check] = Field(description="All checks, passed or not")

    @classmethod
    def from_domain(cls, certificate: domain.Certificate) -> Self:
        """Return the model of a certificate."""
        stop = certificate.first_unproven
        return cls.model_validate({
            "proven": certificate.proven,
            "min_clearance": certificate.min_clearance,
            "observed_clearance": certificate.observed_clearance,
            "pair": certificate.pair,
            "time": certificate.time,
            "points": certificate.points,
            "proven_until": certificate.proven_until,
            "first_unproven": None if stop is None else Pair.from_domain(stop),
            "unchecked": certificate.unchecked,
            "checks": certificate.checks,
        })


class Part(ResponseModel):
    """A part of the motion, from rest to rest."""

    kind: Literal["free", "approach", "retreat", "line"] = Field(
        description="Purpose of the part; all but `free` are straight lines of the tool"
    )
    begin: float = Field(description="First instant [s]")
    end: float = Field(description="Last instant [s]")
    length: float = Field(description="Length of the tool's path [m]")
    num_waypoints: int = Field(
        description="Number of waypoints of its part of `path`, both ends included"
    )


# What `?include=` may leave out of an answer: it grows with the motion and the scene.
LARGE_PARTS = ("path", "trajectory", "certificate", "stages")


def _may_lack_large_parts(schema: dict[str, Any]) -> None:
    schema["required"] = [name for name in schema["required"] if name not in LARGE_PARTS]


class PlanResult(ResponseModel):
    """Result of a solved problem; `?include=` leaves out `path, trajectory, certificate, stages`.

    A part that is left out is absent. Without `include` all are there.
    """

    model_config = ConfigDict(json_schema_extra=_may_lack_large_parts)

    goal_configuration: Row = Field(
        description="Configuration at which the motion reaches the goal: its end, except "
        "with a retreat [rad or m]"
    )
    goal_index: int = Field(description="Index of the goal's candidate that it is, from 0")
    start: Row = Field(
        description="Configuration at which it starts, clipped into the limits [rad or m]"
    )
    start_clipped: Row = Field(
        description="Change of the given start by clipping, at most 1e-6 [rad or m]"
    )
    path: Rows = Field(description="Untimed waypoints, one row each [rad or m]")
    parts: list[Part] = Field(
        default=[], description="The free motion and the straight lines it is made of, in order"
    )
    trajectory: Trajectory = Field(description="The timed motion, sampled as `retime` says")
    certificate: Certificate = Field(description="The proof")
    stages: Stages = Field(description="Reports of all stages")
    cut_short: list[CutStage] | None = Field(
        default=None,
        description="Stages that ended early because of the clock, by their names in "
        "`timings`; their results may be different another time. Empty if the "
        "same request gives the same numbers again, except `timings`; null if "
        "made by a version that did not record it",
    )
    digest: str = Field(description="sha256 over the delivered numbers")

    @classmethod
    def from_domain(
        cls, plan: MotionPlan, trajectory: Trajectory, cuts: Iterable[str] = ()
    ) -> Self:
        """Return the result of a plan.

        Args:
            plan: The plan.
            trajectory: Its samples.
            cuts: What a deadline cut after the plan.
        """
        return cls.model_validate({
            "goal_configuration": plan.goal_configuration,
            "goal_index": plan.goal_index,
            "start": plan.start,
            "start_clipped": plan.start_clipped,
            "path": plan.path.waypoints,
            "parts": plan.parts,
            "trajectory": trajectory,
            "certificate": Certificate.from_domain(plan.certificate),
            "stages": Stages.from_domain(plan.stages),
            "cut_short": [*plan.cut_short, *cuts],
            "digest": plan.digest,
        })
