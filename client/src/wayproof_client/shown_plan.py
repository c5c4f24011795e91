"""ShownPlan: what a plan has for notebooks."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pydantic import PrivateAttr

from wayproof_client.answer import Answer
from wayproof_client.plan_view import PlanView, facts_html


@dataclass(frozen=True)
class _Source:
    """Where a view comes from, which makes no difference between plans."""

    view: Callable[[Any], PlanView] | None = field(default=None, compare=False)


class ShownPlan(Answer):
    """A plan that a notebook shows: with its replay and plots, if a `Client` got it."""

    _source: _Source = PrivateAttr(default=_Source())

    def show_by(self, view: Callable[[Any], PlanView]) -> None:
        """Fetch what a notebook shows by a function of the plan, once it is shown."""
        self._source = _Source(view)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: facts alone, while there is no motion to be seen."""
        plan: Any = self
        view = self._source.view
        return facts_html(plan) if view is None or plan.state != "succeeded" else view(plan).html
