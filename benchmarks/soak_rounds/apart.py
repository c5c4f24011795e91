"""ApartSoak: two robots of one scene, each carried out by an execution of its own, at once."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any, override

import numpy as np

from benchmarks.service_load.host import Host
from benchmarks.serving.server import pause
from benchmarks.soak_rounds.cell import BASES, Cell
from benchmarks.soak_rounds.checks import (
    Presence,
    Round,
    arm_at,
    motion_of,
    obstacle_at,
    of_the_end,
)
from benchmarks.soak_rounds.rounds import DEEDS, SHARES, Soak

# One that may go on with another motion has all robots of its scene.
_POLICIES = ("stop", "slow")
_MAX_TRIES = 20
# Of each robot, places that an obstacle is held against.
_MAX_NEAR = 12


@dataclass
class _Lane:
    """What one robot does in a round."""

    robot: str
    plan: dict[str, Any]
    execution: str
    made: Round


@dataclass
class ApartRounds:
    """Executions of two robots that ran at once.

    Attributes:
        lanes: Rounds by robot; a robot for which none was proven beside the other has none.
        refusals: How often a motion was refused beside the other one.
    """

    lanes: dict[str, Round]
    refusals: int
    obstacles: list[Presence] = field(default_factory=list[Presence])


class ApartSoak(Soak):
    """Has executions of two robots carried out at once, each steered by itself."""

    def __init__(self, host: Host, cell: Cell, rng: np.random.Generator) -> None:
        """Post the scene; see `Soak`."""
        super().__init__(host, cell, 2, rng)
        self._count = 1  # of robots in each plan
        self._lanes: list[_Lane] = []
        self._refusals = 0

    def next_rounds(self) -> ApartRounds:
        """Carry motions of both out, do things to them, and return them once both have ended."""
        obstacles: list[Presence] = []
        self._lanes, self._refusals = [], 0
        names = [name for name, _, _ in BASES]
        for robot in self._rng.permutation(names):
            self._begin(str(robot), obstacles)
        for _ in range(int(self._rng.integers(2, 7))):
            pause(float(self._rng.uniform(0.05, 0.6)))
            lane = self._lanes[int(self._rng.integers(len(self._lanes)))]
            self._turn_to(lane)
            what = str(self._rng.choice(list(DEEDS), p=SHARES))
            told = DEEDS[what](self)
            lane.made.done.append(what if told is None else f"{what} {told}")
        for lane in self._lanes:
            self._turn_to(lane)
            self._let_it_end()
        for lane in self._lanes:
            self._turn_to(lane)
            lane.made.events, lane.made.execution = self._events(), self._now()
            lane.made.state = self._get(f"/v1/scenes/{self._scene}/state")
        lanes = {lane.robot: lane.made for lane in self._lanes}
        return ApartRounds(lanes, self._refusals, obstacles)

    def _turn_to(self, lane: _Lane) -> None:
        """Have what is done be done to one of both."""
        self._plan, self._execution, self._round = lane.plan, lane.execution, lane.made
        self._group = lane.robot

    def _begin(self, robot: str, obstacles: list[Presence]) -> None:
        """Begin an execution of a robot, if a motion of it is proven beside what moves."""
        self._group = robot
        for _ in range(_MAX_TRIES):
            plan = self._planned()
            terms = {"plan": plan["id"], "on_conflict": str(self._rng.choice(_POLICIES))}
            terms |= {"speed": float(self._rng.uniform(0.04, 0.12))}
            answer = self._host.http.post("/v1/executions", json=terms)
            if answer.is_success:
                motion = self._get(f"/v1/plans/{plan['id']}/trajectory?polynomial=true")
                done = [f"{terms['on_conflict']} at {terms['speed']:.2f}"]
                made = Round({}, [], {}, {0: motion["polynomial"]}, obstacles, done)
                self._lanes.append(_Lane(robot, plan, answer.json()["id"], made))
                return
            if answer.json()["code"] != "not_certified":
                answer.raise_for_status()
            self._refusals += 1

    @override
    def _near(self, samples: Sequence[tuple[float, Any]], now: float, reach: float) -> list[Any]:
        """Return places of both robots that an obstacle must not be at."""
        near = {str(self._group): _thinned(super()._near(samples, now, reach))}
        live = self._get(f"/v1/scenes/{self._scene}/state")["robots"]
        for name, _, _ in BASES:
            near.setdefault(name, [arm_at(live, name)])
        for lane in self._lanes:
            if lane.robot == self._group:
                continue
            status = self._get(f"/v1/executions/{lane.execution}")["status"]
            result = lane.plan["result"]["trajectory"]
            other = list(zip(result["times"], result["positions"], strict=True))
            if status is not None:
                near[lane.robot] += _thinned(super()._near(other, status["time"], reach))
        return [np.concatenate(pair) for pair in product(*(near[name] for name, _, _ in BASES))]


def _thinned(rows: Sequence[Any]) -> list[Any]:
    step = max(1, len(rows) // _MAX_NEAR)
    return list(rows[::step])


def faults_of_both(rounds: ApartRounds, cell: Cell) -> Iterator[str]:
    """Yield what does not hold: ends, events, the live state, and what either robot touched."""
    for robot, made in rounds.lanes.items():
        yield from (f"{robot}: {fault}" for fault in of_the_end(made))
        statuses = [data for kind, _, data in made.events if kind == "status"]
        live = arm_at(made.state["robots"], robot)
        if statuses and np.abs(live - statuses[-1]["positions"]).max() > 1e-9:
            yield f"{robot}: the live state is not what was measured last"
        if any(one["status"] != "at_rest" for one in made.state["robots"]):
            yield f"{robot}: robots are {[one['status'] for one in made.state['robots']]}"
    rows, instants = configurations_of_both(rounds)
    obstacles = [obstacle_at(rounds.obstacles, at) for at in instants]
    yield from (f"collision: {each}" for each in cell.touching(rows, obstacles))


def configurations_of_both(rounds: ApartRounds) -> tuple[list[np.ndarray], list[float]]:
    """Return where both robots were at every instant at which either is looked at."""
    motions = {robot: motion_of(made) for robot, made in rounds.lanes.items()}
    moved = {robot: (rows, at) for robot, (rows, at) in motions.items() if rows}
    instants = sorted({at for _, times in moved.values() for at in times})
    if not instants:
        return [], []
    state = next(iter(rounds.lanes.values())).state["robots"]
    columns: list[np.ndarray] = []
    for name, _, _ in BASES:
        if name not in moved:  # it rests
            columns.append(np.tile(arm_at(state, name), (len(instants), 1)))
            continue
        rows, times = np.array(moved[name][0]), np.maximum.accumulate(moved[name][1])
        columns.append(np.stack([np.interp(instants, times, q) for q in rows.T], axis=1))
    return list(np.hstack(columns)), instants
