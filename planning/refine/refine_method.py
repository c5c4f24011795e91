"""Refiner: what a method of refinement does, and the curve and report that it returns."""

from typing import Protocol, runtime_checkable

from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.deadline import Deadline
from planning.refine.request import RefineRequest
from planning.world.world import World

# A curve that the retimer is to time, or one that has its own time; None for the path itself.
type Refined = JointSpline | TimedTrajectory | None


@runtime_checkable
class Refiner(Protocol):
    """A method of refinement (interface).

    What every implementation promises, by `tests/refine/test_refiner_contract.py`: the ends stay;
    position limits, margins and path constraints hold at the samples of the audit; no motion is
    worse by the request's objective than the one along the path; after the deadline nothing begins;
    the same request gives the same bytes unless the deadline cut it.

    Not promised: anything between the samples. The caller certifies every motion.
    """

    def unsupported_reason(self, request: RefineRequest) -> str:
        """Return why a path cannot be refined, or ""."""
        ...

    def refine(
        self, world: World, request: RefineRequest, deadline: Deadline, report: RefineReport
    ) -> tuple[Refined, RefineReport]:
        """Return a better curve from the path's start to its goal, or None; and the report.

        Args:
            world: The scene, loaded.
            request: Path, limits, margins and constraints; `unsupported_reason` has none.
            deadline: End of the refinement.
            report: Report to be completed.
        """
        ...
