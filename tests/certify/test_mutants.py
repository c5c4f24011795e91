"""Motions just within or just beyond a tolerance: the certifier distinguishes them.

Each way to break a motion leaves everything else sound, so that one check alone can refuse it; how
much it is broken is random, from a little above that check's tolerance up.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform

from planning.certify.certifier import CertifyRequest, certify
from planning.domain.geometry.pose import Pose
from planning.domain.report.certificate import Certificate
from planning.domain.request.constraint import KeepIn, PlacedBox, TightLimits
from planning.domain.robot.joints import JointLimits
from planning.world.collision.margins import PairMargins
from planning.world.drake_model import DrakeModel
from tests.certify.chains import Builder, P, Robot
from tests.certify.conftest import quintic
from tests.certify.sound_motions import (
    Sound,
    as_quick_as_may_be,
    backwards,
    cut_at,
    peak_use,
    plus_piece,
    sound_motions,
)
from tests.clocks import no_hurry
from tests.profiles import PROFILE, num_cases, rng_of

# Number of cases from each scene, for every way to break a motion or to leave it sound.
COUNT = num_cases(18)
type Rng = np.random.Generator
type Question = tuple[DrakeModel, CertifyRequest]

# x (1 - x)^2: changes no end value, and of the end slopes only the first.
KINK = np.array([0.0, 1.0, -2.0, 1.0])
# x^3 (1 - x)^3: zero at both ends with its first two derivatives.
BUMP = np.array([0.0, 0.0, 0.0, 1.0, -3.0, 3.0, -1.0])
# x^4 (x - 1): adds nothing but a slope at the end.
LAST = np.array([0.0, 0.0, 0.0, 0.0, -1.0, 1.0])


@cache
def motions() -> tuple[Sound, ...]:
    return tuple(sound_motions(COUNT, 20_261_121 + PROFILE.seed))


def certificate_of(question: Question) -> Certificate:
    return certify(*question, no_hurry(30.0))[0]


def beyond(rng: Rng, tolerance: float, decades: float = 3.0) -> float:
    """Return an amount above a tolerance, uniform in its logarithm."""
    return float(tolerance * 10 ** rng.uniform(0.02, decades))


def within(rng: Rng, tolerance: float) -> float:
    return float(tolerance * rng.uniform(0.0, 0.95))


def lifted(limits: JointLimits, *rates: str) -> JointLimits:
    return replace(limits, **{rate: getattr(limits, rate) * 1e3 for rate in rates})


def some_joint(sound: Sound, rng: Rng) -> int:
    return int(rng.integers(sound.request.group.num_velocities))


def halves(sound: Sound, rng: Rng):
    motion = sound.unhurried
    return cut_at(motion, motion.duration * rng.uniform(0.2, 0.8))


def torn(sound: Sound, rng: Rng, gap: float) -> Question:
    motion = halves(sound, rng)
    coefficients = np.array(motion.coefficients)
    coefficients[1, 0, some_joint(sound, rng)] += gap
    return sound.world.drake, sound.of(replace(motion, coefficients=coefficients))


def kinked(sound: Sound, rng: Rng, share: float) -> Question:
    motion, joint = halves(sound, rng), some_joint(sound, rng)
    slope = share * float(sound.request.limits.velocity[joint])
    width = motion.duration - motion.breaks[1]
    return sound.world.drake, sound.of(plus_piece(motion, 1, joint, KINK * slope * width))


def at_limit(order: int) -> Callable[[Sound, Rng, float], Question]:
    """Return a mutation that raises one rate above its limit, and the limits of the others."""
    rates = ("velocity", "acceleration", "jerk")

    def mutate(sound: Sound, _: Rng, excess: float) -> Question:
        request = sound.request
        others = [rate for rate in rates if rate != rates[order - 1]]
        motion = as_quick_as_may_be(
            request.trajectory, request.group, request.limits, -excess, (order,)
        )
        limits = lifted(request.limits, *others)
        return sound.world.drake, replace(sound.of(motion), limits=limits, jerk=order == 3)

    return mutate


def spiked(sound: Sound, rng: Rng, excess: float) -> Question:
    """Let one joint accelerate too much for 6 ms between two samples that are 10 ms apart."""
    request, joint = sound.request, some_joint(sound, rng)
    motion = sound.unhurried
    begin = 0.01 * int(rng.integers(10, int(motion.duration / 0.01) - 10)) + 0.002
    span = begin, begin + 0.006
    motion = cut_at(motion, *span)

    def use(size: float) -> float:
        return peak_use(plus_piece(motion, 1, joint, BUMP * size), request.limits, 2, span)

    low, high = 0.0, 1e-2
    while high - low > 1e-12:
        middle = (low + high) / 2
        low, high = (low, middle) if use(middle) > 1 + excess else (middle, high)
    spike = plus_piece(motion, 1, joint, BUMP * high)
    samples = spike.tangents(spike.sample_times(0.01), 2)
    assert (np.abs(samples) < request.limits.acceleration).all()
    return sound.world.drake, sound.of(spike)


def past_a_bound(sound: Sound, rng: Rng, excess: float) -> Question:
    request, joint = sound.request, some_joint(sound, rng)
    q = request.trajectory.positions(np.linspace(0, request.trajectory.duration, 4000))[:, joint]
    lower, upper = np.array(request.limits.lower), np.array(request.limits.upper)
    if rng.random() < 0.5:
        upper[joint] = q.max() - excess
    else:
        lower[joint] = q.min() + excess
    limits = replace(request.limits, lower=lower, upper=upper)
    return sound.world.drake, replace(request, limits=limits)


def elsewhere(field: str) -> Callable[[Sound, Rng, float], Question]:
    def mutate(sound: Sound, rng: Rng, distance: float) -> Question:
        request = sound.request
        step = np.zeros(request.group.num_positions)
        step[some_joint(sound, rng)] = distance
        return sound.world.drake, replace(request, **{field: getattr(request, field) + step})

    return mutate


def moving_at_an_end(sound: Sound, rng: Rng, speed: float) -> Question:
    motion = sound.unhurried
    at_start = rng.random() < 0.5
    motion = backwards(motion) if at_start else motion
    motion = plus_piece(motion, 0, some_joint(sound, rng), LAST * speed * motion.duration)
    motion = backwards(motion) if at_start else motion
    return sound.world.drake, sound.of(motion)


def margin_broken(sound: Sound, _: Rng, lack: float) -> Question:
    clear = certificate_of((sound.world.drake, sound.request))
    low, high = sorted(clear.pair)
    margins = PairMargins(0.0, {(low, high): clear.observed_clearance + lack})
    return sound.world.drake, replace(sound.request, margins=margins)


def constraint_broken(sound: Sound, rng: Rng, excess: float) -> Question:
    request = sound.request
    motion, group = request.trajectory, request.group
    q = motion.positions(np.linspace(0, motion.duration, 400))
    if rng.random() < 0.5:
        joint = some_joint(sound, rng)
        bound = {group.position_names[joint]: (-100.0, float(q[:, joint].max()) - excess)}
        return sound.world.drake, replace(request, constraints=(TightLimits(bound),))
    frame = group.tool_frames[0]
    heights = sound.world.frame_poses(frame, sound.world.embed(group, q))[:, 2, 3]
    # Two metres deep, with its upper face below the highest point of the way.
    middle = np.array([0.0, 0.0, float(heights.max()) - excess - 1.0])
    box = PlacedBox(np.array([np.inf, np.inf, 2.0]), Pose(middle, np.eye(4)[0]))
    return sound.world.drake, replace(request, constraints=(KeepIn(frame, box),))


def no_trajectory(sound: Sound, rng: Rng, _: float) -> Question:
    motion = cut_at(sound.request.trajectory, sound.request.trajectory.duration / 2)
    breaks, coefficients = np.array(motion.breaks), np.array(motion.coefficients)
    match int(rng.integers(5)):
        case 0:
            coefficients[1, int(rng.integers(7)), some_joint(sound, rng)] = np.nan
        case 1:
            coefficients[0, int(rng.integers(7)), some_joint(sound, rng)] = np.inf
        case 2:
            breaks[1] = breaks[2]
        case 3:
            breaks[1] = breaks[2] + 1e-6
        case _:
            breaks += 1e-9
    broken = replace(motion, breaks=breaks, coefficients=coefficients)
    return sound.world.drake, replace(sound.request, trajectory=broken)


def past_a_plate(gap: float, at: float) -> Question:
    """Send a ball of 10 mm along z at 5 m/s, past a plate of 1 mm, or through it: 50 mm a sample.

    With a negative gap the plate stands in its way at a place between two samples.
    """
    builder = Builder()
    builder.link(P, Sphere(0.01))
    beside = 0.01 + gap + 0.5
    builder.obstacle("plate", Box(1.0, 1.0, 0.001), RigidTransform(np.array([beside, 0.0, at])))
    robot: Robot = builder.build()
    trajectory = quintic(robot.group, np.array([-1.0]), np.array([1.0]), 0.75)
    return robot.model, robot.request(trajectory, PairMargins(0.0))


def through_a_plate(_: Sound, rng: Rng, depth: float) -> Question:
    _, request = past_a_plate(-depth, 0.0)
    z = request.trajectory.positions(request.trajectory.sample_times(0.01))[:, 0]
    gaps = [(a + b) / 2 for a, b in pairwise(z) if b - a > 0.03]
    at = float(rng.choice(gaps))
    assert np.abs(z - at).min() > 0.0115  # no sample touches it
    return past_a_plate(-depth, at)


# How a motion is broken; what alone refuses it; the tolerance, and decades above it.
MUTANTS = {
    "torn": (torn, "continuity", 1e-6, 3),
    "kinked": (kinked, "velocity continuity", 1e-5, 3),
    "too fast": (at_limit(1), "velocity", 1e-6, 5),
    "too jerky": (at_limit(3), "jerk", 1e-6, 5),
    "spiked between samples": (spiked, "acceleration", 1e-6, 5),
    "past a bound": (past_a_bound, "position", 1e-6, 4),
    "from elsewhere": (elsewhere("start"), "start", 1e-6, 5),
    "to elsewhere": (elsewhere("goals"), "goal", 1e-6, 5),
    "moving at an end": (moving_at_an_end, "rest", 1e-6, 3),
    "through a plate between samples": (through_a_plate, "clearance", 1e-6, 3.9),
    "nearer than its margin": (margin_broken, "clearance", 1.1e-6, 4),
    "against a constraint": (constraint_broken, "constraint 0", 1.1e-6, 4),
    "no trajectory": (no_trajectory, "form", 1.0, 1),
}


@pytest.mark.campaign
@pytest.mark.timeout(3600 if PROFILE.is_campaign else 300)
@pytest.mark.parametrize("name", MUTANTS)
def test_mutants_are_refused_by_the_expected_check_alone(name: str) -> None:
    mutate, check, tolerance, decades = MUTANTS[name]
    rng = rng_of(list(MUTANTS).index(name))
    for sound in motions():
        certificate = certificate_of(mutate(sound, rng, beyond(rng, tolerance, decades)))
        assert not certificate.proven
        assert {failed.name.partition(":")[0] for failed in certificate.failed} == {check}


def margin_kept(sound: Sound, _: Rng) -> Question:
    clear = certificate_of((sound.world.drake, sound.request))
    floor = clear.min_clearance
    low, high = sorted(clear.pair)
    margins = PairMargins(0.0, {(low, high): floor - 1e-6})
    return sound.world.drake, replace(sound.request, margins=margins)


def in_pieces(sound: Sound, rng: Rng) -> Question:
    motion = sound.request.trajectory
    return sound.world.drake, sound.of(cut_at(motion, *rng.uniform(0, motion.duration, 20)))


# What is done to a sound motion that leaves it sound, by just enough where there is a tolerance.
SOUND: dict[str, Callable[[Sound, Rng], Question]] = {
    "as it is": lambda sound, _: (sound.world.drake, sound.request),
    "in pieces": in_pieces,
    "backwards": lambda sound, _: (
        sound.world.drake,
        sound.of(backwards(sound.request.trajectory)),
    ),
    "slower": lambda sound, rng: (
        sound.world.drake,
        sound.of(sound.request.trajectory.time_scaled(rng.uniform(1, 5))),
    ),
    "hardly torn": lambda sound, rng: torn(sound, rng, within(rng, 1e-6)),
    "hardly kinked": lambda sound, rng: kinked(sound, rng, within(rng, 1e-5)),
    "at its velocity": lambda sound, rng: at_limit(1)(sound, rng, within(rng, 9e-7)),
    "at its jerk": lambda sound, rng: at_limit(3)(sound, rng, -1e-6),
    "at a bound": lambda sound, rng: past_a_bound(sound, rng, within(rng, 9e-7)),
    "hardly elsewhere": lambda sound, rng: elsewhere("start")(sound, rng, within(rng, 1e-6)),
    "hardly moving": lambda sound, rng: moving_at_an_end(sound, rng, within(rng, 1e-6)),
    "past a plate": lambda _, rng: past_a_plate(10 ** rng.uniform(-5, -2), rng.uniform(-0.8, 0.8)),
    "at its margin": margin_kept,
    "within a constraint": lambda sound, rng: constraint_broken(sound, rng, -1e-4),
}


@pytest.mark.campaign
@pytest.mark.timeout(3600 if PROFILE.is_campaign else 300)
@pytest.mark.parametrize("name", SOUND)
def test_sound_motions_are_proven(name: str) -> None:
    rng = rng_of(list(SOUND).index(name))
    for sound in motions():
        certificate = certificate_of(SOUND[name](sound, rng))
        assert certificate.proven, certificate.failed
