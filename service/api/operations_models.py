"""Health of the server."""

from typing import Literal

from pydantic import Field

from service.api.models import ResponseModel


class Health(ResponseModel):
    """That the server is there."""

    status: Literal["ok"] = Field(description="Always `ok`: no answer is the other answer")
    version: str = Field(description="Of Wayproof")
    kernel: str = Field(
        description="Instruction set of the native collision kernel; `none` where it was not "
        "built, and Drake answers everything, more slowly"
    )


class Readiness(ResponseModel):
    """Whether the server takes jobs."""

    status: Literal["ready"] = Field(description="Always `ready`; else the answer is 503")
    queued: dict[str, int] = Field(description="Jobs that wait, by lane")
    running: dict[str, int] = Field(description="Jobs that run, by lane")
