"""Rounds: an execution after the other in one scene, each steered, blocked and killed at random."""

import json
import signal
import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

from benchmarks.service_load.host import Host
from benchmarks.serving.processes import cpu_seconds, workers
from benchmarks.serving.server import pause
from benchmarks.soak_rounds.cell import BASES, SIDE, Cell, document
from benchmarks.soak_rounds.checks import FINAL, Presence, Round

_HOME = (0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0)
# How far joints are turned from home, at most [rad].
_TURNS = (2.5, 0.4, 0.4, 0.5, 0.5, 1.0)
_POLICIES = ("stop", "slow", "replan")
# How long an execution may take once it is left alone [s], and to begin to move.
_PATIENCE = 120.0
_PERIOD = 0.02
# An obstacle is put so far ahead of the robot at least, at its speed: what is nearer than it can
# stop is met, as is documented [s].
_AHEAD = 3.0


class Soak:
    """Has executions carried out in one scene of one server, which may be killed meanwhile."""

    def __init__(self, host: Host, cell: Cell, count: int, rng: np.random.Generator) -> None:
        """Post the scene.

        Args:
            host: Of the server.
            cell: Knows what would be met before a robot could stop.
            count: Of robots, 1 or 2; two of them move as one group.
            rng: Says what is done when.
        """
        self._host, self._cell, self._rng, self._count = host, cell, rng, count
        host.need()
        self._scene: str = host.post("/v1/scenes", document(count))["id"]
        names = [name for name, _, _ in BASES[:count]]
        self._group: str | list[str] = names[0] if count == 1 else names
        self._round: Round | None = None
        self._plan: dict[str, Any] = {}
        self._execution = ""

    def next_round(self) -> Round:
        """Carry out a motion, do things to it, and return it once it has ended."""
        self._plan = self._planned()
        motion = self._get(f"/v1/plans/{self._plan['id']}/trajectory?polynomial=true")
        trajectories = {0: motion["polynomial"]}
        policy = str(self._rng.choice(_POLICIES))
        speed = float(self._rng.uniform(0.04, 0.12))
        terms = {"plan": self._plan["id"], "speed": speed, "on_conflict": policy}
        self._execution = self._host.post("/v1/executions", terms)["id"]
        made = Round({}, [], {}, trajectories, done=[f"{policy} at {speed:.2f}"])
        self._round = made
        for _ in range(int(self._rng.integers(1, 5))):
            pause(float(self._rng.uniform(0.05, 0.6)))
            what = str(self._rng.choice(list(DEEDS), p=SHARES))
            told = DEEDS[what](self)
            made.done.append(what if told is None else f"{what} {told}")
        self._let_it_end()
        made.events = self._events()
        made.execution = self._now()
        made.state = self._get(f"/v1/scenes/{self._scene}/state")
        for kind, _, data in made.events:
            if kind == "motion":
                trajectories[data["number"]] = data["trajectory"]
        return made

    def _planned(self) -> dict[str, Any]:
        """Return a plan from where the robots are to somewhere; not every place can be reached."""
        while True:
            goal = [
                float(q + self._rng.uniform(-turn, turn))
                for _ in range(self._count)
                for q, turn in zip(_HOME, _TURNS, strict=True)
            ]
            request = {"scene": self._scene, "group": self._group}
            request |= {"goal": {"type": "joint", "positions": goal}, "refine": {"method": "none"}}
            plan: dict[str, Any] = self._host.post("/v1/plans?wait=60", request)
            if plan["state"] == "succeeded":
                return plan

    def _let_it_end(self) -> None:
        """Take everything back, and wait until it has ended; what rests for good is canceled."""
        self.clear()
        self._send("resume")
        self._send("speed", {"speed": 1.0})
        until = time.monotonic() + _PATIENCE
        while self._now()["state"] not in FINAL and time.monotonic() < until:
            pause(_PERIOD)

    def _events(self) -> list[tuple[str, int, dict[str, Any]]]:
        text = self._host.http.get(f"/v1/executions/{self._execution}/events").text
        found = []
        for block in text.replace("\r\n", "\n").split("\n\n"):
            fields = dict(line.split(": ", 1) for line in block.splitlines() if ": " in line[:8])
            if "event" in fields:
                found.append((fields["event"], int(fields["id"]), json.loads(fields["data"])))
        return found

    def _now(self) -> dict[str, Any]:
        return self._get(f"/v1/executions/{self._execution}")

    def _get(self, path: str) -> Any:
        answer = self._host.http.get(path)
        answer.raise_for_status()
        return answer.json()

    def _send(self, what: str, body: Any = None) -> None:
        """Steer the execution; one that has ended refuses."""
        answer = self._host.http.post(f"/v1/executions/{self._execution}/{what}", json=body)
        if answer.status_code not in {200, 409}:
            answer.raise_for_status()

    def pause(self) -> None:
        """Have it rest on its path."""
        self._send("pause")

    def resume(self) -> None:
        """Have it go on."""
        self._send("resume")

    def speed(self) -> str:
        """Change its speed, and which way it goes."""
        speed = float(self._rng.uniform(-0.15, 0.15))
        self._send("speed", {"speed": speed})
        return f"{speed:.2f}"

    def cancel(self) -> None:
        """Have it end."""
        self._send("cancel")

    def clear(self) -> None:
        """Take the obstacle out of the scene."""
        made = self._round
        if made is None or not made.obstacles or made.obstacles[-1].until is not None:
            return
        made.obstacles[-1].until = datetime.now(UTC)
        self._edit({"op": "remove", "object": "late"})

    def block(self) -> str:
        """Put an obstacle where the tool will be; not so near that it could not stop."""
        self.clear()
        status = self._now()["status"]
        result = self._plan["result"]["trajectory"]
        if status is None or status["motion"] != 0 or self._round is None:
            return "not begun"
        now, fastest = status["time"], max(0.05, abs(status["path_velocity"] or 0.0))
        samples = list(zip(result["times"], result["positions"], strict=True))
        later = [q for t, q in samples if t > now + _AHEAD * fastest]
        near = self._near(samples, now, _AHEAD * fastest)
        if not later:
            return "too late"
        place = self._tool(later[int(self._rng.integers(len(later)))])
        if self._cell.touching(near, [place] * len(near)):
            return "too near"
        shape = {"box": [SIDE] * 3}
        late = {"name": "late", "shape": shape, "pose": {"position": place}}
        answer = self._edit({"op": "add", "object": late})
        if answer is None:
            return "refused"
        self._round.obstacles.append(Presence(place, datetime.now(UTC)))
        verdicts = [one["verdict"] for one in answer["executions"]]
        near = [one["seconds"] for one in answer["executions"] if one["verdict"] == "conflict"]
        return f"{verdicts} {near}"

    def _near(self, samples: Sequence[tuple[float, Any]], now: float, reach: float) -> list[Any]:
        """Return places that the robot may come to before it could rest.

        Args:
            samples: Times along the motion [s] and positions.
            now: Where the robot is [s].
            reach: How far from there [s].
        """
        return [np.array(q) for t, q in samples if abs(t - now) <= reach]

    def _tool(self, q: list[float]) -> list[float]:
        [found] = self._host.post(
            f"/v1/scenes/{self._scene}/fk", {"group": self._group, "configurations": [q]}
        )["results"]
        tools = [pose["position"] for name, pose in found.items() if name.endswith("::tcp")]
        chosen: list[float] = tools[int(self._rng.integers(len(tools)))]
        return chosen

    def _edit(self, operation: dict[str, Any]) -> Any:
        answer = self._host.http.patch(
            f"/v1/scenes/{self._scene}", json={"operations": [operation]}
        )
        return answer.json() if answer.is_success else None

    def kill_driver(self) -> str:
        """Kill the process that moves the robot: the one that computes most."""
        before = {one: _seconds_of(one.pid) for one in workers(self._host.pid)}
        pause(0.2)
        spent = {one: _seconds_of(one.pid) - was for one, was in before.items()}
        busiest = max(spent, key=lambda one: spent[one])
        if self._now()["state"] in FINAL or spent[busiest] <= 0:
            return "none"
        busiest.send(_KILL)
        return str(busiest.pid)

    def kill_server(self) -> None:
        """Kill the server, and start another one on its data."""
        self._host.kill_and_restart()


def _seconds_of(pid: int) -> float:
    try:
        return cpu_seconds(pid)
    except OSError:
        return 0.0


_KILL = signal.SIGKILL
# What is done, and in what share of all deeds.
DEEDS: dict[str, Callable[[Soak], str | None]] = {
    "pause": Soak.pause,
    "resume": Soak.resume,
    "speed": Soak.speed,
    "cancel": Soak.cancel,
    "block": Soak.block,
    "clear": Soak.clear,
    "kill driver": Soak.kill_driver,
    "kill server": Soak.kill_server,
}
SHARES = [0.12, 0.12, 0.24, 0.05, 0.3, 0.1, 0.04, 0.03]
