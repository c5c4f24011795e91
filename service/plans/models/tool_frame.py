"""ToolFrame: which frame a goal is for."""

from typing import Annotated

from pydantic import Field

from service.api.models import Name

type ToolFrame = Annotated[
    Name | None,
    Field(description="The tool frame: any that the group moves; null for its default"),
]
