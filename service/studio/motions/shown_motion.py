"""ShownMotion: the motion that is looked at, and that the robot can carry out."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

import httpx
import viser

from service.client.errors import ApiError
from service.studio.api import evidence_of
from service.studio.cell import Cell
from service.studio.motions.motion import load_motion
from service.studio.motions.motion_panel import MotionPanel
from service.studio.motions.side_by_side import SideBySide
from service.studio.plans.failure_view import place_of
from service.studio.robots.robot_panel import RobotPanel

_LABEL, _OF_ANOTHER_GOAL = "Motion", "Motion, to the goal before"


class ShownMotion:
    """At most one motion, in a folder of its own."""

    def __init__(
        self,
        gui: viser.GuiApi,
        place: viser.GuiTabHandle,
        robot: RobotPanel,
        on_fault: Callable[[Exception], None],
    ) -> None:
        """Show none yet.

        Args:
            gui: Of one browser.
            place: Where the folder is shown.
            robot: Carries motions out.
            on_fault: Is told what goes wrong.
        """
        self._gui, self._place, self._robot, self._on_fault = gui, place, robot, on_fault
        self._panel: MotionPanel | None = None
        self._folder: viser.GuiFolderHandle | None = None
        self._cell: Cell | None = None
        # Motions beside it play it from another thread than the one that closes it.
        self._lock = threading.RLock()

    @property
    def plan(self) -> str | None:
        """Id of the plan whose motion is shown."""
        return None if self._panel is None else self._panel.motion.plan

    def show(self, cell: Cell, job: Mapping[str, Any], beside: SideBySide) -> None:
        """Show the motion of a plan that succeeded, in place of the one before.

        Args:
            cell: The scene.
            job: The plan, with its result.
            beside: Other motions of the scene, which move along.
        """
        with self._lock:
            self.close()
            cell.view.mark_pairs([], {})
            motion = load_motion(cell.api, cell.scene.id, cell.group, job, cell.view.moving)
            with self._place:
                self._folder = self._gui.add_folder(_LABEL)
            with self._folder:
                self._panel = MotionPanel(
                    self._gui, cell, motion, beside, self._offer, self._on_fault
                )
            self._cell = cell
            self._offer()

    def play_beside(self) -> None:
        """Play the motion with those that are beside it."""
        with self._lock:
            if self._panel is not None:
                self._panel.play_beside()

    def execute(self) -> None:
        """Carry the motion out; where the server refuses it, show when, and which bodies meet."""
        cell, panel = self._cell, self._panel
        if cell is None or panel is None:
            return
        panel.leave()
        cell.view.show_ghost(None)
        try:
            self._robot.execute(cell, panel.motion.plan)
        except ApiError as fault:
            evidence = evidence_of(fault)
            place = place_of(evidence) if fault.code == "not_certified" else None
            if place is None:
                self._on_fault(fault)
                return
            panel.badge.refute(evidence)
            panel.show_place(*place)
            self._robot.say_refused(fault.problem.detail, evidence)
        except httpx.HTTPError as fault:
            self._on_fault(fault)

    def look_again(self) -> None:
        """Say what is known of the motion, once the scene is another one."""
        if self._panel is not None:
            self._panel.look_again()
            self._offer()

    def note_other_goal(self) -> None:
        """Make room for another goal: a motion that was carried out goes, others are renamed."""
        panel = self._panel
        if panel is None or self._folder is None:
            return
        if self._robot.carried_out == panel.motion.plan:
            self.close()
            self._robot.clear()
            return
        panel.leave()
        if self._folder.label != _OF_ANOTHER_GOAL:
            self._folder.label = _OF_ANOTHER_GOAL

    def close(self) -> None:
        """Show no motion."""
        with self._lock:
            if self._panel is not None:
                self._panel.close()
            if self._folder is not None:
                self._folder.remove()
            self._panel = self._folder = None

    def _offer(self) -> None:
        if self._panel is not None and self._panel.badge.is_refuted:
            self._robot.offer(None)
        elif self._panel is not None:
            self._robot.offer(self._panel.motion.plan, is_sure=not self._panel.badge.is_stale)
