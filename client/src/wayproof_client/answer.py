"""Answer: what every model of an answer is."""

from pydantic import BaseModel, ConfigDict


class Answer(BaseModel):
    """An answer, or a part of one; members that a newer server has are kept as they came."""

    # Schemas are built when they are first used: there are some hundred, and programs use a few.
    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True, protected_namespaces=())
