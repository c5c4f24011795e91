"""Sound motions in the bundled scenes, and how to take one apart and put it together again."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import factorial

import numpy as np

from planning.certify.certifier import CertifyRequest
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.world.world import World
from tests.certify.conftest import request_for, smallest_distance
from tests.conftest import bundled_world

RATES = ("velocity", "acceleration", "jerk")
SCENES = (("ur5e_pickup", "arm"), ("panda_shelf", "panda"), ("irb120_cell", "arm"))
# A motion this far from everything stays free when it is changed a little [m].
_CLEAR = 0.005
_LOOKS = 4000


@dataclass(frozen=True)
class Sound:
    """A motion that is known to be sound without asking the certifier.

    Attributes:
        world: Its scene.
        name: Of the group that moves.
        request: Its certify request; its fastest joint uses a limit to 1 - 1e-6.
    """

    world: World
    name: str
    request: CertifyRequest

    def of(self, trajectory: TimedTrajectory) -> CertifyRequest:
        """Return the certify request of another trajectory, between its own ends."""
        return request_for(self.world, self.name, trajectory)

    @property
    def unhurried(self) -> TimedTrajectory:
        """The motion with room below its limits."""
        return self.request.trajectory.time_scaled(1.3)


def sound_motions(count: int, seed: int) -> list[Sound]:
    """Return motions that begin where the scenes have their robots, alternating between scenes."""
    rng = np.random.default_rng(seed)
    sources = [_of_scene(*scene, rng) for scene in SCENES]
    return [next(sources[i % len(sources)]) for i in range(count)]


def _of_scene(scene: str, name: str, rng: np.random.Generator) -> Iterator[Sound]:
    world = bundled_world(scene)
    group = world.group(name)
    limits, home = world.limits(group), world.positions(group)
    while True:
        delta = rng.normal(0.0, 0.5, len(home))
        wiggle = rng.normal(0.0, 0.1, len(home))
        motion = _motion(group, home, delta, wiggle)
        motion = as_quick_as_may_be(motion, group, limits, 1e-6)
        q = motion.positions(np.linspace(0.0, motion.duration, _LOOKS))
        within = ((q > limits.lower + 0.01) & (q < limits.upper - 0.01)).all()
        if within and smallest_distance(world, motion, name, 0.03) > _CLEAR:
            yield Sound(world, name, request_for(world, name, motion))


def _motion(
    group: JointGroup, start: np.ndarray, delta: np.ndarray, wiggle: np.ndarray
) -> TimedTrajectory:
    """Return a motion of a second that begins and ends at rest, without acceleration."""
    coefficients = np.zeros((1, 7, len(delta)))
    for power, step, bump in ((3, 10, 64), (4, -15, -192), (5, 6, 192), (6, 0, -64)):
        coefficients[0, power] = step * delta + bump * wiggle
    return TimedTrajectory(group.joints, np.array([0.0, 1.0]), start[None], coefficients)


def peak_use(
    motion: TimedTrajectory,
    limits: JointLimits,
    order: int,
    span: tuple[float, float] | None = None,
) -> float:
    """Return the largest rate over its limit at many samples: a lower bound on the true one."""
    times = np.linspace(*(span or (0.0, motion.duration)), _LOOKS)
    rates = motion.tangents(times, order)
    bounds = getattr(limits, RATES[order - 1])
    return max(
        float(np.linalg.norm(rates[:, list(block)], axis=1).max() / bound)
        for block, bound in zip(limits.blocks, bounds, strict=True)
    )


def as_quick_as_may_be(
    motion: TimedTrajectory,
    group: JointGroup,
    limits: JointLimits,
    spare: float,
    orders: tuple[int, ...] = (1, 2),
) -> TimedTrajectory:
    """Return the motion slowed or sped up until a rate is this far below its limit, as a share."""
    assert motion.joints == group.joints
    factor = max((peak_use(motion, limits, k) / (1 - spare)) ** (1 / k) for k in orders)
    return motion.time_scaled(factor)


def cut_at(motion: TimedTrajectory, *instants: float) -> TimedTrajectory:
    """Return the same motion in more pieces, each expanded anew about its beginning."""
    breaks = np.unique([*motion.breaks, *instants])
    begins = breaks[:-1]
    terms = motion.coefficients.shape[1]
    taylor = [motion.tangents(begins, k) / factorial(k) for k in range(terms)]
    pieces, _ = motion.locate(begins)
    return TimedTrajectory(motion.joints, breaks, motion.bases[pieces], np.stack(taylor, axis=1))


def plus_piece(
    motion: TimedTrajectory, piece: int, joint: int, powers: np.ndarray
) -> TimedTrajectory:
    """Return the motion with a polynomial in x = 0 .. 1 added to one joint on one piece."""
    terms = max(motion.coefficients.shape[1], len(powers))
    padding = ((0, 0), (0, terms - motion.coefficients.shape[1]), (0, 0))
    coefficients = np.pad(motion.coefficients, padding)
    width = motion.breaks[piece + 1] - motion.breaks[piece]
    coefficients[piece, : len(powers), joint] += powers / width ** np.arange(len(powers))
    return replace(motion, coefficients=coefficients)


def backwards(motion: TimedTrajectory) -> TimedTrajectory:
    """Return the motion from its end to its start."""
    ends, terms = motion.breaks[1:], motion.coefficients.shape[1]
    widths = np.diff(motion.breaks)
    rows = []
    for piece, width in enumerate(widths):
        polynomials = [np.polynomial.Polynomial(c) for c in motion.coefficients[piece].T]
        turned = [p(np.polynomial.Polynomial([width, -1.0])) for p in polynomials]
        rows.append(np.stack([np.pad(p.coef, (0, terms - len(p.coef))) for p in turned], axis=1))
    return TimedTrajectory(
        motion.joints,
        motion.duration - np.concatenate([ends[::-1], [0.0]]),
        motion.bases[::-1].copy(),
        np.array(rows[::-1]),
    )
