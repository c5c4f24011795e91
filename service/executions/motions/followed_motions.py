"""Motions that a runner goes on with while it carries one out, and the places it stays between."""

from typing import Any

from planning.errors import ProblemInvalid
from planning.execute.runner import Runner
from service.executions.models import FollowedMotion
from service.executions.tasks import MOTION, Bounds, Commands, NextMotion
from service.jobs.context import TaskContext


class FollowedMotions:
    """Has a runner heed verdicts and next motions, each once, and none that has been overtaken.

    Attributes:
        controls: The last that were heeded, as they came; None before.
    """

    def __init__(self, runner: Runner, context: TaskContext) -> None:
        """Begin with the motion that was asked for.

        Args:
            runner: Follows it.
            context: Is told of every motion that is followed.
        """
        self.controls: dict[str, Any] | None = None
        self._runner = runner
        self._context = context
        self._bounds: Bounds | None = None
        self._refused: NextMotion | None = None
        self._motions: list[FollowedMotion] = []

    @property
    def number(self) -> int:
        """Number of the motion that is followed; 0 for the one that was asked for."""
        return len(self._motions)

    def heed(self, commands: Commands) -> None:
        """Do what commands say of bounds and of the next motion."""
        bounds = commands.bounds
        if bounds is not None and bounds != self._bounds and self._is_news(bounds):
            self._bounds = bounds
            self._runner.keep_between(bounds.behind, bounds.until)
        if commands.next is not None and self._may_follow(commands.next):
            self._follow(commands.next)

    def _is_news(self, bounds: Bounds) -> bool:
        known = -1 if self._bounds is None else self._bounds.revision
        return bounds.motion == self.number and bounds.revision >= known

    def _may_follow(self, following: NextMotion) -> bool:
        """Whether a motion is the next one, and proven in the newest revision that is known."""
        known = -1 if self._bounds is None else self._bounds.revision
        is_next = following.number == self.number + 1
        return is_next and following.revision >= known and following != self._refused

    def _follow(self, following: NextMotion) -> None:
        left_at = self._runner.execution.time
        trajectory = following.trajectory.to_domain()
        try:
            self._runner.switch_to(trajectory, left_at if following.is_spliced else 0.0)
        except ProblemInvalid:  # the robot is elsewhere by now: its server tries another one
            self._refused = following
            return
        motion = FollowedMotion(
            number=following.number,
            plan=following.plan,
            revision=following.revision,
            is_spliced=following.is_spliced,
            left_at=left_at,
            duration=trajectory.duration,
        )
        self._motions.append(motion)
        told = {
            "number": motion.number,
            "motions": [each.model_dump() for each in self._motions],
            "trajectory": following.trajectory.model_dump(),
        }
        self._context.emit_whole(MOTION, told)
