"""PlanView: a plan to look at: facts, its replay in 3-D, and plots."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

# What is drawn unless something else is wanted.
PLOTS = ("position", "velocity", "acceleration", "clearance")


@dataclass(frozen=True)
class PlanView:
    """A plan as a piece of HTML that needs nothing else.

    Attributes:
        html: For a notebook or a page.
    """

    html: str

    def _repr_html_(self) -> str:
        return self.html

    @classmethod
    def of(cls, plan: Any, replay: str, plots: Mapping[str, str]) -> "PlanView":
        """Put a view together.

        Args:
            plan: The plan.
            replay: Its page.
            plots: Drawings (SVG) by name.
        """
        # The page's scripts have an origin of their own there, and reach nothing of the notebook.
        frame = (
            '<iframe sandbox="allow-scripts" style="width:100%;height:480px;border:0" '
            f'title="replay of {escape(plan.id)}" srcdoc="{escape(replay)}"></iframe>'
        )
        drawings = "".join(
            f'<img alt="{escape(name)}" style="max-width:49%" '
            f'src="data:image/svg+xml;base64,{base64.b64encode(svg.encode()).decode()}">'
            for name, svg in plots.items()
        )
        return cls(f"<div>{facts_html(plan)}{frame}<div>{drawings}</div></div>")


def facts_html(plan: Any) -> str:
    """Return a table of what is most asked of a plan."""
    rows = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th><td>{escape(value)}</td></tr>"
        for name, value in _facts(plan).items()
    )
    return f"<table>{rows}</table>"


def _facts(plan: Any) -> dict[str, str]:
    facts = {"plan": plan.id, "state": str(plan.state)}
    if plan.failure is not None:
        facts |= {"failure": plan.failure.code, "why": plan.failure.detail}
    result = plan.result
    if result is not None and result.trajectory is not None:
        facts["duration"] = f"{result.trajectory.duration:.3f} s"
    if result is not None and result.certificate is not None:
        proof = result.certificate
        facts["proven"] = "yes" if proof.proven else "no"
        if proof.min_clearance is not None:
            facts["min clearance"] = f"{1000 * proof.min_clearance:.1f} mm"
    return facts
