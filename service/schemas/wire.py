"""Wire: the base of every wire type."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, StringConstraints

type Name = Annotated[str, StringConstraints(min_length=1, max_length=256)]
type Identifier = Annotated[str, StringConstraints(min_length=1, max_length=128)]


class Wire(BaseModel):
    """What is asked: a JSON object with no unknown fields."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Answer(BaseModel):
    """What is answered: clients must expect fields that are added later."""

    model_config = ConfigDict(extra="ignore", frozen=True)
