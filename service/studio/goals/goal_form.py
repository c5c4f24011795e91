"""GoalForm: any goal that the server knows, as a form made from its OpenAPI document."""

from collections.abc import Mapping
from typing import Any

from service.studio.forms.form import Drawing
from service.studio.forms.schema import field_of

_GOAL = "Goal"
# What inverse kinematics is asked for; other goals are found out by a plan.
SOLVED = {"pose", "region", "relative"}


class GoalForm:
    """A goal of any kind."""

    def __init__(
        self, drawing: Drawing, document: Mapping[str, Any], first: Mapping[str, Any]
    ) -> None:
        """Show the form, in the container that is open.

        Args:
            drawing: Makes its inputs.
            document: OpenAPI.
            first: What it is filled with.
        """
        self._input = drawing.input(field_of(document, _GOAL))
        self._input.fill(first)

    def goal(self) -> dict[str, Any]:
        """Return the goal as the API wants it.

        Raises:
            FormError: What was written by hand cannot be read.
        """
        found: dict[str, Any] = self._input.value()
        return found
