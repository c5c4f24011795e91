"""What is where during a motion: solids of every body, and the pairs that must keep apart."""

from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np

from planning.domain.arrays import Array
from tests.adversary.cases import Document, Setting
from tests.adversary.draws.motions import around, positions, sample_places
from tests.adversary.draws.other_robots import Standing, read_other_robots
from tests.adversary.draws.shapes import radius_of
from tests.adversary.judge.distances import Near, Solid, make_geometry, nearest
from tests.adversary.judge.kinematics import Robot, pose_matrix

type Pair = frozenset[str]


@dataclass(frozen=True)
class Look:
    """What of a motion is looked at, and how.

    Attributes:
        margin: Of pairs that are not both of one robot, unless the scene has another for them
            [m]; None for no margins at all.
        skip: Pairs that are not looked at.
        only: Bodies one of which is in every pair; empty for all.
        until: End of what is looked at [s].
        count: Instants at first.
        also: Instants that are looked at besides [s].
        rounds: How often the neighbourhood of the nearest is looked at again, six times as finely.
    """

    margin: float | None = 0.0
    skip: AbstractSet[Pair] = field(default_factory=frozenset)
    only: AbstractSet[str] = field(default_factory=frozenset)
    until: float = np.inf
    count: int = 240
    also: tuple[float, ...] = ()
    rounds: int = 3


@dataclass(frozen=True)
class Seen:
    """The nearest that was seen, and when [s]."""

    near: Near
    time: float

    @property
    def spare(self) -> float:
        return self.near.spare

    @property
    def distance(self) -> float:
        return self.near.distance


class Stage:
    """The bodies of a case, placed by the judge's own kinematics, to be looked at again.

    Attributes:
        unchecked: Pairs that the product does not look at: links that a joint joins, unless it says
            otherwise.
        by_pair: Margins that the scene has for single pairs [m].
    """

    def __init__(
        self, robot: Robot, case: Document, base: Array, others: Mapping[str, Standing]
    ) -> None:
        self.robot, self.base, self.size = robot, base, float(case["robot"]["size"])
        self._case, self._others = case, others
        entries = case.get("more", {}).get("margins", [])
        self.by_pair = {frozenset(entry["bodies"]): float(entry["margin"]) for entry in entries}
        self._shapes = [
            (f"r::{link}", shape, pose, make_geometry(shape, self.size))
            for link, shapes in robot.shapes.items()
            for shape, pose in shapes
        ]
        self.unchecked = {frozenset((f"r::{j.parent}", f"r::{j.child}")) for j in robot.joints}
        self._things: list[tuple[Document, Any]] = []
        standing = [thing for other in others.values() for thing in other.things()]
        for thing in [*standing, *case.get("objects", [])]:
            self.add(thing)

    @classmethod
    def of(cls, setting: Setting) -> "Stage":
        others = read_other_robots(setting.case, setting.folder)
        return cls(setting.robot, setting.case, setting.base, others)

    def add(self, thing: Document) -> None:
        """Put one more object there."""
        other = self._others.get(thing.get("robot", ""))
        placed = thing if other is None else other.held(thing)
        self._things.append((placed, make_geometry(thing["shape"], self.size)))

    def remove(self, thing: Document) -> None:
        """Take an object away."""
        name = thing["name"]
        self._things = [entry for entry in self._things if entry[0]["name"] != name]

    def displaced(self, rng: np.random.Generator, by: float) -> "Stage":
        """Return the same with every obstacle moved by so much [m], each its own way."""
        moved = Stage(self.robot, {**self._case, "objects": []}, self.base, {})
        for thing, geometry in self._things:
            way = rng.normal(size=3)
            shift = np.eye(4)
            if not (thing.get("on") and "pose" not in thing):
                shift[:3, 3] = by * way / np.linalg.norm(way)
            moved._things.append(({**thing, "pose_shift": shift}, geometry))
        return moved

    @property
    def own(self) -> frozenset[str]:
        """The bodies of the robot that moves, and what it holds."""
        return frozenset(body for body in self.bodies if self.owner(body) == "r")

    @property
    def suspect(self) -> int:
        """The number of the defect that what is wrong here is likely to be; 0 for a new one."""
        if any(
            joint.kind == "floating" and not np.array_equal(joint.origin, np.eye(4))
            for joint in self.robot.joints
        ):
            return 8
        return 7 if any("half_space" in thing["shape"] for thing, _ in self._things) else 0

    @property
    def bodies(self) -> list[str]:
        """Names of all that has a shape."""
        links = [body for body, *_ in self._shapes]
        return list(dict.fromkeys([*links, *(thing["name"] for thing, _ in self._things)]))

    def solids(self, q: dict[str, Array], count: int) -> list[Solid]:
        """Return every solid at some configurations."""
        placed = self.robot.place(q, self.base, count)
        found = [
            Solid(body, shape, placed[body[3:]] @ pose, geometry, radius_of(shape))
            for body, shape, pose, geometry in self._shapes
        ]
        world = np.broadcast_to(np.eye(4), (count, 4, 4))
        for thing, geometry in self._things:
            if "pose" in thing:
                pose = world @ thing["pose"]
            else:
                frame = placed[thing["on"]] if thing.get("on") else world
                pose = frame @ pose_matrix(thing["xyz"], thing["rpy"])
            if "pose_shift" in thing:
                pose = thing["pose_shift"] @ pose
            shape = thing["shape"]
            found.append(Solid(thing["name"], shape, pose, geometry, radius_of(shape)))
        return found

    def holder(self, body: str) -> str:
        """Return what a body is rigid with: a link; the root is rigid with the world."""
        if body.startswith("r::"):
            return self.robot.rigid_with(body[3:])
        thing = self._thing(body)
        return thing.get("cluster") or self.robot.rigid_with(
            self.robot.root if "pose" in thing else thing.get("on") or self.robot.root
        )

    def _thing(self, body: str) -> Document:
        return next((thing for thing, _ in self._things if thing["name"] == body), {})

    def owner(self, body: str) -> str:
        """Return the robot that a body is part of, or held by; "" for what stands by itself."""
        robot, has_robot, _ = body.partition("::")
        thing = {} if has_robot else self._thing(body)
        return robot if has_robot else thing.get("robot", "r") if thing.get("on") else ""

    def is_moved(self, body: str) -> bool:
        """Return whether a body may move with the robot."""
        return self.owner(body) == "r" and self.holder(body) != self.robot.root

    @property
    def fixed(self) -> set[Pair]:
        """The pairs that a motion moves neither body of."""
        still = [body for body in self.bodies if not self.is_moved(body)]
        return {frozenset(pair) for pair in combinations(still, 2)}

    def is_rigid(self, pair: Pair) -> bool:
        """Return whether nothing moves two bodies against each other."""
        return len({self.holder(body) for body in pair}) == 1

    def pairs(self, solids: list[Solid], look: Look) -> list[tuple[Solid, Solid, float]]:
        """Return the pairs of solids that must keep apart, with their margins [m]."""
        found: list[tuple[Solid, Solid, float]] = []
        for i, a in enumerate(solids):
            for b in solids[i + 1 :]:
                names = frozenset((a.body, b.body))
                is_meant = not look.only or bool(names & look.only)
                if is_meant and names not in look.skip and not self.is_rigid(names):
                    found.append((a, b, self._margin(names, look)))
        return found

    def _margin(self, pair: Pair, look: Look) -> float:
        """Return the distance that two bodies owe each other [m]."""
        if look.margin is None:
            return 0.0
        owners = {self.owner(body) for body in pair}
        is_one_robot = len(owners) == 1 and owners != {""}
        return self.by_pair.get(pair, 0.0 if is_one_robot else look.margin)

    def worst(self, motion: Document, look: Look) -> Seen | None:
        """Return where a motion has the least to spare; None if nothing can touch."""
        until = min(look.until, motion["breaks"][-1])
        # By themselves: of many instants at once only the likeliest are measured.
        places = [sample_places(motion, look.count)]
        places += [around(motion, time, 0.0, 1) for time in look.also]
        seen = [self._least(motion, part, look, until) for part in places]
        best = min((s for s in seen if s is not None), key=lambda s: s.spare, default=None)
        width = until / look.count
        for _ in range(look.rounds):
            if best is None:
                return None
            near = Look(look.margin, look.skip, frozenset(s.body for s in best.near.solids))
            again = self._least(motion, around(motion, best.time, width, 15), near, until)
            best = again if again is not None and again.spare < best.spare else best
            width /= 6
        return best

    def _least(self, motion: Document, places: Any, look: Look, until: float) -> Seen | None:
        pieces, local, times = places
        within = times <= until
        pieces, local, times = pieces[within], local[within], times[within]
        solids = self.solids(positions(motion, pieces, local), len(times))
        last: Near | None = None
        for last in nearest(self.pairs(solids, look), self.size):  # noqa: B007
            pass
        return None if last is None else Seen(last, float(times[last.index]))

    def at(self, motion: Document, time: float, pair: tuple[str, str]) -> float:
        """Return the distance of two bodies at an instant [m]."""
        pieces, local, _ = around(motion, time, 0.0, 1)
        solids = self.solids(positions(motion, pieces, local), 1)
        of = [[s for s in solids if s.body == body] for body in pair]
        chosen = [(a, b, 0.0) for a in of[0] for b in of[1]]
        return min((near.distance for near in nearest(chosen, self.size)), default=np.inf)
