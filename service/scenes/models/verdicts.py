"""ExecutionVerdict: whether a motion that is carried out holds after an edit of its scene."""

from typing import Literal

from pydantic import Field

from service.api.document.known_values import VerdictCheck
from service.api.models import ResponseModel


class ExecutionVerdict(ResponseModel):
    """Effect of an edit of the scene on an execution that waits or moves."""

    id: str = Field(description="Id of the execution")
    verdict: Literal["unaffected", "conflict"] = Field(
        description="Whether what is left of its motion is proven in this revision"
    )
    action: Literal["stop", "slow", "replan", "ignore"] | None = Field(
        default=None, description="Action that is taken, as the execution's `on_conflict` says"
    )
    check: VerdictCheck | None = Field(
        default=None,
        description="Check of the certificate that fails, mostly `clearance`; `undecided` "
        "if there was no verdict in time, `request` if the motion's terms "
        "name what is gone, `beside` if it may meet another execution",
    )
    other: str | None = Field(
        default=None, description="Id of the execution that it may meet, if that is the check"
    )
    pair: tuple[str, str] | None = Field(
        default=None, description="Full names of the bodies that come too near, if it is about two"
    )
    time: float | None = Field(
        default=None, description="Time along the motion of the conflict [s]"
    )
    seconds: float | None = Field(
        default=None,
        description="Time to that place from where the robot was, at the pace of the motion [s]",
    )
    fraction: float | None = Field(
        default=None, description="Share of the path's length that is done there, 0 to 1"
    )
