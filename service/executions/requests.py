"""Requests to carry a motion out, and to steer it."""

from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from service.api.fingerprint import ADDED
from service.api.models import Identifier, NonNegative, Real, RequestModel
from service.executions.gripping.requests import GripperRequest
from service.trajectories.models import CertifyMotionRequest

type DriverName = Annotated[
    Literal["simulated", "kinematic"],
    Field(
        description="Driver of a motion: `simulated` is Drake's simulation under a joint "
        "controller; `kinematic` is a robot without mass that is always where "
        "it should be, and feels nothing"
    ),
]


class UrRtdeDriver(RequestModel):
    """An arm of Universal Robots, by RTDE."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"type": "ur_rtde", "host": "cell-1"}]}
    )

    type: Literal["ur_rtde"] = Field(description="Protocol of its controller")
    host: Annotated[str, Field(min_length=1, max_length=200)] = Field(
        description="Name of a controller in the server's settings (`WAYPROOF_UR_HOSTS`)"
    )


def rests_when_lost(driver: str | UrRtdeDriver) -> bool:
    """Return whether the robot of a driver that is gone rests where it was last measured."""
    return not isinstance(driver, UrRtdeDriver)


class ExecutionTerms(RequestModel):
    """Terms on which a motion is carried out, and the plan or plans that it is from."""

    plan: Identifier | None = Field(
        default=None,
        description="Id of a plan that succeeded; null for several, and for a motion of one's own",
    )
    plans: Annotated[
        Annotated[list[Identifier], Field(min_length=1, max_length=16)] | None, ADDED
    ] = Field(
        default=None,
        description="Ids of plans of one scene, which are carried out as one motion with one "
        "clock, the most urgent first; no joint is in two of them",
    )
    delays: Annotated[
        Annotated[list[NonNegative], Field(min_length=1, max_length=16)] | None, ADDED
    ] = Field(
        default=None,
        description="Time at which each of `plans` begins [s]; null for the smallest "
        "delays that are proven, as `POST /trajectories/schedule` finds them",
    )
    gripper: Annotated[GripperRequest | None, ADDED] = Field(
        default=None,
        description="Open or close a gripper, from where its fingers are, and take hold of an "
        "object or let it go",
    )
    driver: DriverName | UrRtdeDriver = Field(
        default="simulated", description="Driver of the motion"
    )
    speed: Annotated[Real, Field(gt=0, le=100)] = Field(
        default=1.0,
        description="Seconds of the motion per second; above 1 the simulation's clock runs faster "
        "than real time, and the motion stays as it is",
    )
    on_conflict: Annotated[Literal["stop", "slow", "replan", "ignore"], ADDED] = Field(
        default="stop",
        description="Action while it moves if an edit of the scene is in its way: `stop` "
        "comes to rest on the path and ends (`path_blocked`); `slow` rests "
        "before the conflict and goes on once a later edit has cleared the "
        "way; `replan` does so too, and goes on with a new plan to the same "
        "configuration, without a rest where that is proven; `ignore` only "
        "tells. With `replan`, no other robot of the scene may move until it "
        "ends",
    )
    on_not_certified: Annotated[Literal["refuse", "replan"], ADDED] = Field(
        default="refuse",
        description="Action if the plan's motion does not begin where the robot is, or is "
        "not proven in the latest revision: `refuse` answers 409; `replan` "
        "waits for a new plan from where the robot is to the same "
        "configuration (`replanned`), and answers 409 if there is none. With `when_busy: "
        "wait` that is done once its robots are free; without a plan it ends with the refusal",
    )
    when_busy: Annotated[Literal["refuse", "wait"], ADDED] = Field(
        default="refuse",
        description="Action if another execution moves one of its robots, or waits for "
        "one: `refuse` answers 409; `wait` begins once they are free, in the "
        "order of requests, and is proven then, from where they are",
    )
    title: Annotated[str, Field(min_length=1, max_length=200)] | None = Field(
        default=None, description="Title of the motion in replays of the scene"
    )


class ExecutionRequest(ExecutionTerms):
    """Carry out a plan, several plans as one motion, a motion of your own, or that of a gripper."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"plan": "pln_5b1e9a7d4c623f0c", "driver": "simulated", "speed": 1.0},
                {"plans": ["pln_5b1e9a7d4c623f0c", "pln_92ab3c44de5f4a10"]},
                {
                    "gripper": {
                        "scene": "scn_3f0c5b1e9a7d4c62",
                        "group": "arm::gripper",
                        "grasp": {"object": "can"},
                    }
                },
            ]
        }
    )

    trajectory: Annotated[CertifyMotionRequest | None, ADDED] = Field(
        default=None,
        description="A motion of your own, as `POST /trajectories/certify` takes it, without "
        "`revision`: it is proven in the latest one, and refused (`not_certified`) if it is not",
    )

    @model_validator(mode="after")
    def _one_motion(self) -> Self:
        motions = (self.plan, self.plans, self.trajectory, self.gripper)
        if sum(each is not None for each in motions) != 1:
            message = (
                "plan: exactly one of `plan`, `plans`, `trajectory` and `gripper` must be given"
            )
            raise ValueError(message)
        if self.delays is not None and len(self.delays) != len(self.plans or ()):
            message = "delays: there must be one for each of `plans`"
            raise ValueError(message)
        if self.trajectory is not None and self.trajectory.revision is not None:
            message = "trajectory.revision: leave it out, an execution is in the latest revision"
            raise ValueError(message)
        return self

    @model_validator(mode="after")
    def _policies_fit(self) -> Self:
        if self.plan is None and self.on_not_certified == "replan":
            message = "on_not_certified: only one plan can be made anew"
            raise ValueError(message)
        grasp = None if self.gripper is None else self.gripper.grasp
        if grasp is not None and grasp.by == "contact" and self.driver != "simulated":
            message = "gripper.grasp.by: only the driver `simulated` has contacts that hold objects"
            raise ValueError(message)
        if self.on_conflict == "replan" and (self.plans is not None or self.gripper is not None):
            message = "on_conflict: only one motion can be planned anew, not several as one, nor "
            message += "that of a gripper"
            raise ValueError(message)
        if isinstance(self.driver, UrRtdeDriver) and self.speed > 1:
            message = "speed: a robot has no clock that could run faster, so it is 1 at most"
            raise ValueError(message)
        if isinstance(self.driver, UrRtdeDriver) and self.on_conflict == "replan":
            message = "on_conflict: what sampling leaves of the clearance is known of one motion"
            raise ValueError(message)
        return self

    @property
    def group(self) -> str:
        """Group of a gripper, or of a motion of one's own; a plan knows its own."""
        moved = self.trajectory or self.gripper
        return "" if moved is None else moved.group

    @property
    def terms(self) -> ExecutionTerms:
        """All but the motion of one's own, which is long."""
        return ExecutionTerms.model_validate(self.model_dump(exclude={"trajectory"}))


class SpeedRequest(RequestModel):
    """Change how fast a motion is carried out, and which way."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"speed": 0.5}, {"speed": -0.2}]})

    speed: Annotated[Real, Field(ge=-100, le=100)] = Field(
        description="Seconds of the motion per second: 0 rests on the path, negative goes "
        "back along it; only drivers with a clock of their own go beyond 1 "
        "and -1"
    )
