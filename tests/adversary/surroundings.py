"""What is where during a motion: solids of every body, and the pairs that must keep apart."""

from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tests.adversary.cases import Document, Setting
from tests.adversary.distances import Near, Solid, make_geometry, nearest
from tests.adversary.kinematics import Robot, pose_matrix
from tests.adversary.motions import around, positions, sample_places
from tests.adversary.shapes import radius_of

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Pair = frozenset[str]


@dataclass(frozen=True)
class Look:
    """What of a motion is looked at, and how.

    Attributes:
        margin: Of pairs that are not both of the robot [m].
        skip: Pairs that are not looked at.
        only: Bodies one of which is in every pair; empty for all.
        until: End of what is looked at [s].
        count: Instants at first.
        also: Instants that are looked at besides [s].
        rounds: How often the neighbourhood of the nearest is looked at again, six times as finely.
    """

    margin: float = 0.0
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
        unlooked: Pairs that the product does not look at: links that a joint joins, unless it says
            otherwise.
    """

    def __init__(self, robot: Robot, case: Document, base: Array) -> None:
        self.robot, self.base, self.size = robot, base, float(case["robot"]["size"])
        self._shapes = [
            (f"r::{link}", shape, pose, make_geometry(shape, self.size))
            for link, shapes in robot.shapes.items()
            for shape, pose in shapes
        ]
        self.unlooked = {frozenset((f"r::{j.parent}", f"r::{j.child}")) for j in robot.joints}
        self._things: list[tuple[Document, Any]] = []
        for thing in case.get("objects", []):
            self.add(thing)

    @classmethod
    def of(cls, setting: Setting) -> "Stage":
        return cls(setting.robot, setting.case, setting.base)

    def add(self, thing: Document) -> None:
        """Put one more object there."""
        self._things.append((thing, make_geometry(thing["shape"], self.size)))

    def remove(self, thing: Document) -> None:
        """Take an object away."""
        self._things = [entry for entry in self._things if entry[0] is not thing]

    def displaced(self, rng: np.random.Generator, by: float) -> "Stage":
        """Return the same with every obstacle moved by so much [m], each its own way."""
        things = []
        for thing, _ in self._things:
            way = rng.normal(size=3)
            shift = np.zeros(3) if thing.get("on") else by * way / np.linalg.norm(way)
            things.append({**thing, "xyz": (np.array(thing["xyz"]) + shift).tolist()})
        case = {"robot": {"size": self.size}, "objects": things}
        return Stage(self.robot, case, self.base)

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
        links = list(dict.fromkeys(body for body, *_ in self._shapes))
        return links + [thing["name"] for thing, _ in self._things]

    def solids(self, q: dict[str, Array], count: int) -> list[Solid]:
        """Return every solid at some configurations."""
        placed = self.robot.place(q, self.base, count)
        found = [
            Solid(body, shape, placed[body[3:]] @ pose, geometry, radius_of(shape))
            for body, shape, pose, geometry in self._shapes
        ]
        world = np.broadcast_to(np.eye(4), (count, 4, 4))
        for thing, geometry in self._things:
            frame = placed[thing["on"]] if thing.get("on") else world
            pose = frame @ pose_matrix(thing["xyz"], thing["rpy"])
            shape = thing["shape"]
            found.append(Solid(thing["name"], shape, pose, geometry, radius_of(shape)))
        return found

    def holder(self, body: str) -> str:
        """Return the link that a body is rigid with; the root is rigid with the world."""
        link = body[3:] if body.startswith("r::") else self._held(body) or self.robot.root
        return self.robot.rigid_with(link)

    def _held(self, body: str) -> str:
        return next((t.get("on", "") for t, _ in self._things if t["name"] == body), "")

    def _is_own(self, body: str) -> bool:
        return body.startswith("r::") or bool(self._held(body))

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
                    own = self._is_own(a.body) and self._is_own(b.body)
                    found.append((a, b, 0.0 if own else look.margin))
        return found

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
