"""RequestModel and ResponseModel: the bases of what goes over HTTP as JSON."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Strict, StringConstraints

type Name = Annotated[str, StringConstraints(min_length=1, max_length=256)]
type Identifier = Annotated[str, StringConstraints(min_length=1, max_length=128)]
# Whoever writes "no" or 0 would be surprised by one answer or the other.
type Boolean = Annotated[bool, Strict()]


UNRECORDED = (
    "What has happened and the database does not hold yet, because it is full, locked or away: "
    "`cancel`, `controls`, `events`, `end`. It is written as soon as it can be; what was asked for "
    "is done all the same"
)


class RequestModel(BaseModel):
    """What is asked: a JSON object with no unknown fields."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class ResponseModel(BaseModel):
    """What is answered: clients must expect fields that are added later.

    It can be made from an object of the domain that has its fields as attributes.
    """

    model_config = ConfigDict(extra="ignore", frozen=True, from_attributes=True)
