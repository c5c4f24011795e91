"""MotionPanel: a planned motion: play, time slider, proof, curves, the tool's trace."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import viser

from service.studio.cell import Cell
from service.studio.motions.checks import words_of
from service.studio.motions.motion import Motion
from service.studio.motions.nearest_mark import NearestMark
from service.studio.motions.nearness import Nearness
from service.studio.motions.player import Player
from service.studio.motions.plot import Plot
from service.studio.motions.proof_badge import ProofBadge
from service.studio.motions.proof_panel import ProofPanel
from service.studio.motions.series import Curves
from service.studio.motions.side_by_side import SideBySide
from service.studio.motions.time_slider import TimeSlider
from service.studio.motions.trace import (
    BY_CLEARANCE,
    BY_LIMIT,
    clearance_colors,
    legend,
    limit_colors,
)
from service.studio.newest import Newest
from service.studio.numbers import Array

# Instants at which the clearance is looked at, for the trace, its curve and the nearest points.
_NUM_LOOKS = 100
_CLEARANCE = "clearance"
# While it plays, the cursor of the plot follows once in a few pictures.
_PICTURES_PER_CURSOR = 4


class MotionPanel:
    """A motion, shown by the ghost."""

    def __init__(
        self,
        gui: viser.GuiApi,
        cell: Cell,
        motion: Motion,
        beside: SideBySide,
        on_verdict: Callable[[], None],
        on_fault: Callable[[Exception], None],
    ) -> None:
        """Show a motion, and play it once.

        Args:
            gui: Where it is shown, in the container that is open.
            cell: The scene.
            motion: Planned in it.
            beside: Other motions, which move along.
            on_verdict: Called once it was proven, or refuted, in a newer revision of the scene.
            on_fault: Is told what goes wrong.
        """
        self.motion, self._beside = motion, beside
        self._cell, self._looks = cell, Newest(on_fault)
        self._is_shown = True
        self._nearness: Nearness | None = None
        self._trace: viser.SceneNodeHandle | None = None
        self._lock, self._is_closed = threading.Lock(), False
        self._mark = NearestMark(cell.client.scene)
        self._num_pictures = 0
        self._player = Player(motion.duration, self._follow)
        self.badge = ProofBadge(gui, cell, motion.job, on_verdict, on_fault)
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY)
        self._slider = TimeSlider(gui, motion.duration, self._seek)
        self._play.on_click(lambda _: self.toggle())
        ProofPanel(gui, motion.certificate["checks"], self._go_to)
        with gui.add_folder("Over time") as folder:
            self._kind: Any = gui.add_dropdown("Curves", (*motion.series.curves, _CLEARANCE))
        self._plot = Plot(gui, folder, *self._curves())
        with folder:
            self._color: Any = gui.add_dropdown("Path colour", (BY_CLEARANCE, BY_LIMIT))
            self._legend = gui.add_html(legend(motion.series, BY_CLEARANCE))
        self._kind.on_update(lambda _: self._plot.draw(*self._curves()))
        self._color.on_update(lambda _: self._draw_trace())
        self._draw_trace()
        self._looks.ask(self._look)
        self._reach()
        self.toggle()

    def toggle(self) -> None:
        """Play from where it is, or from the start if it is at the end; or stop."""
        if self._player.is_playing:
            self._player.stop()
            return
        self._cell.view.mark_pairs([], {})
        self._play.label, self._play.icon = "Pause", viser.Icon.PLAYER_PAUSE
        self._player.play(self._slider.value, self._end)

    def play_beside(self) -> None:
        """Play all motions from the start, once others are beside; with none, show this one."""
        self._player.stop()
        self._reach()
        if not self._beside.jobs:
            self._seek()
            return
        self._slider.value = 0.0
        self.toggle()

    def show_place(self, time: float, pair: Mapping[str, Any]) -> None:
        """Go to a time, and mark two bodies that meet then.

        Args:
            time: When [s].
            pair: `bodies`, `points` and `depth`, as the API has them.
        """
        self._slider.value = time
        self._seek()
        nearest = None if self._nearness is None else self._nearness.at(time)
        if nearest is not None and {*pair["bodies"]} - {*nearest.bodies}:
            self._mark.hide()  # one pair is named, not two
        self._cell.view.mark_pairs([pair], self.motion.at(time))

    def leave(self) -> None:
        """Stop to play, go back to the start, and mark nothing: the ghost is elsewhere."""
        self._player.stop()
        self._is_shown = False
        self._mark.hide()
        self._beside.hide()
        self._slider.value = 0.0
        self._plot.move_cursor(0.0)

    def look_again(self) -> None:
        """Measure the motion in the scene as it is now, and say what is proven of it there."""
        self.leave()
        self._nearness = None
        self.badge.look_again()
        self._looks.ask(self._look)

    def close(self) -> None:
        """Stop to play, and take away what is drawn of the motion."""
        self._player.stop()
        self._is_shown = False
        self._looks.close()
        self.badge.close()
        self._beside.hide()
        self._mark.hide()
        with self._lock:  # it may be drawn just now, by what was measured
            self._is_closed = True
            if self._trace is not None:
                self._trace.remove()

    def _reach(self) -> None:
        """Have the time end with the longest motion: this one, or one beside it."""
        end = max(self.motion.duration, self._beside.duration(self.motion.plan))
        self._player.duration = end
        self._slider.reach(end)

    def _move_cursor(self, time: float) -> None:
        """Put the cursor to a time; curves end with this motion."""
        self._plot.move_cursor(min(time, self.motion.duration))

    def _end(self) -> None:
        self._play.label, self._play.icon = "Play", viser.Icon.PLAYER_PLAY
        self._move_cursor(self._slider.value)

    def _follow(self, time: float) -> None:
        self._slider.value = time
        self._num_pictures += 1
        if self._num_pictures % _PICTURES_PER_CURSOR == 0:
            self._move_cursor(time)
        self._show(time)

    def _seek(self) -> None:
        self._player.stop()
        self._cell.view.mark_pairs([], {})
        self._move_cursor(self._slider.value)
        self._show(self._slider.value)

    def _show(self, time: float) -> None:
        self._is_shown = True
        self._cell.view.show_ghost(self.motion.at(time))
        self._beside.show(time, self.motion.plan)
        self._mark.show(None if self._nearness is None else self._nearness.at(time))

    def _go_to(self, check: Mapping[str, Any]) -> None:
        """Go to where and when a check has its worst value."""
        certificate = self.motion.certificate
        bodies = certificate["pair"] if check["name"] == _CLEARANCE else []
        pair = {"bodies": bodies, "points": certificate["points"]}
        self.show_place(float(check["time"]), {**pair, "depth": -float(check["value"])})
        curve = words_of(check).curve
        if curve is not None and curve in self._kind.options and curve != self._kind.value:
            self._kind.value = curve

    def _look(self) -> None:
        """Look at the clearance along the motion, and colour the trace by it."""
        cell, motion = self._cell, self.motion
        rows = np.unique(np.linspace(0, len(motion.times) - 1, _NUM_LOOKS).astype(int))
        verdicts = cell.api.check(cell.scene.id, cell.group.name, motion.positions[rows])
        self._nearness = Nearness(motion.times[rows], verdicts)
        if self._is_shown:
            self._mark.show(self._nearness.at(self._slider.value))
        self._draw_trace()
        if self._kind.value == _CLEARANCE:
            self._plot.draw(*self._curves())

    def _draw_trace(self) -> None:
        tool, kind = self.motion.tool, self._color.value
        self._legend.content = legend(self.motion.series, kind)
        if tool is None:
            return
        if kind == BY_LIMIT:
            colors = limit_colors(self.motion.series, self.motion.times)
        else:
            far = np.full(len(tool), np.inf)
            found = self._nearness
            gap = (
                far if found is None else np.interp(self.motion.times, found.times, found.clearance)
            )
            colors = clearance_colors(gap)
        with self._lock:
            if not self._is_closed:
                self._trace = self._cell.view.draw_trace("plan", tool, colors)

    def _curves(self) -> tuple[Array, Curves]:
        series, kind = self.motion.series, self._kind.value
        if kind != _CLEARANCE:
            return series.times, series.curves[kind]
        found = self._nearness
        if found is None:  # it is drawn again once it was measured
            return series.times, Curves([f"{kind} is measured"], np.zeros((len(series.times), 1)))
        known = np.isfinite(found.clearance)
        gap = 1000 * found.clearance[known]
        if len(gap) < 2:
            return series.times, Curves(["nothing to hit"], np.zeros((len(series.times), 1)))
        return found.times[known], Curves([f"{kind} [mm]"], gap[:, None])
