"""LiveRobots: the robots where the server says that they are."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

import httpx
import numpy as np

from service.client.errors import ApiError
from service.studio.api import Api, ShownGroup
from service.studio.cell import Cell
from service.studio.numbers import Array

# Before the server is asked again, once it has not answered [s].
_PAUSE = 1.0
# States each second: what a browser without a graphics card still draws.
_RATE = 15.0


class LiveRobots:
    """Follows the live state of a scene, in a thread of its own."""

    def __init__(
        self,
        cell: Cell,
        api: Api,
        on_edit: Callable[[int], None],
        on_presence: Callable[[bool], None],
    ) -> None:
        """Begin to follow.

        Args:
            cell: The scene.
            api: A connection of its own, which is closed at the end.
            on_edit: Called with the scene's revision when that is not the one that is drawn.
            on_presence: Called with whether the server answers, when that has changed.
        """
        self._cell, self._api, self._on_edit = cell, api, on_edit
        self._on_presence, self._is_there = on_presence, True
        self._closed = threading.Event()
        self._shown: dict[str, Mapping[str, Any]] = {}
        threading.Thread(target=self._run, daemon=True).start()

    def close(self) -> None:
        """Follow no more."""
        self._closed.set()
        self._api.__exit__(None, None, None)

    def _run(self) -> None:
        while not self._closed.is_set():
            try:
                for state in self._api.live_states(self._cell.scene.id, _RATE):
                    if self._closed.is_set():
                        return
                    self._note(is_there=True)
                    self._follow(state)
            except ApiError:
                return  # the scene is deleted
            except httpx.ConnectError:
                self._note(is_there=False)
                self._closed.wait(_PAUSE)
            except (httpx.HTTPError, RuntimeError):  # RuntimeError: the connection was closed
                self._closed.wait(_PAUSE)
            else:
                self._closed.wait(_PAUSE)

    def _note(self, *, is_there: bool) -> None:
        if is_there != self._is_there:
            self._is_there = is_there
            self._on_presence(is_there)

    def _follow(self, state: Mapping[str, Any]) -> None:
        if state["revision"] != self._cell.scene.revision:
            self._on_edit(int(state["revision"]))
        for robot in state["robots"]:
            if self._shown.get(robot["robot"]) != robot["positions"]:
                self._shown[robot["robot"]] = robot["positions"]
                self._show(robot, state["attached"])

    def _show(self, robot: Mapping[str, Any], held: list[Mapping[str, Any]]) -> None:
        cell, name = self._cell, str(robot["robot"])
        group = next((g for g in cell.scene.groups if g.name.partition("::")[0] == name), None)
        if group is None:
            return
        owned = {item["object"] for item in held if item["frame"].startswith(f"{name}::")}
        bodies = [b for b in cell.view.moving if b.startswith(f"{name}::") or b in owned]
        positions = positions_of(group, robot["positions"])
        found = cell.api.poses(cell.scene.id, group.name, positions, bodies)
        cell.view.show({body: rows[0] for body, rows in found.items()})
        if group.name == cell.group.name:
            cell.positions = positions


def positions_of(group: ShownGroup, joints: Mapping[str, Any]) -> Array:
    """Return the positions of a group [rad or m], shape (nq,).

    Args:
        group: Of a robot.
        joints: A number per joint of the robot, or numbers of a joint with several positions.
    """
    found, counts = list[float](), dict[str, int]()
    for full in group.position_names:
        name = full.partition("::")[2]
        if name not in joints:
            joint = name.rpartition(".")[0]
            index = counts[joint] = counts.get(joint, -1) + 1
            found.append(float(joints[joint][index]))
        else:
            found.append(float(joints[name]))
    return np.array(found)
