"""Motions in small worlds and their certify requests."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import planning
from planning.certify.certifier import CertifyRequest, certify
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Certificate
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.kernel.native import native
from planning.world.world import World
from tests.certify.oracles import for_oracle, oracle
from tests.clocks import no_hurry
from tests.conftest import whole_world


@pytest.fixture(scope="module", params=["kernel", "drake"])
def implementation(request: pytest.FixtureRequest) -> Iterator[str]:
    """Prove clearance by the kernel, and again by Drake alone."""
    if request.param == "kernel" and native() is None:
        pytest.skip("the native code is not built")
    with oracle(kernel=request.param == "kernel"):
        yield request.param


def world_from(text: str) -> World:
    return planning.load_world(planning.parse_scene(text))


def quintic(group: JointGroup, q0: np.ndarray, q1: np.ndarray, duration: float) -> TimedTrajectory:
    """Return the geodesic from q0 to q1 by 10 x^3 - 15 x^4 + 6 x^5, rest to rest."""
    delta = Manifold(group.joints).minus(q1, q0)
    coefficients = np.zeros((1, 6, len(delta)))
    for power, factor in ((3, 10.0), (4, -15.0), (5, 6.0)):
        coefficients[0, power] = factor * delta / duration**power
    return TimedTrajectory(group.joints, np.array([0.0, duration]), q0[None], coefficients)


def request_for(
    world: World, name: str, trajectory: TimedTrajectory, margin: float | None = None
) -> CertifyRequest:
    """Return the certify request of a trajectory, from its own start to its own end."""
    group = world.group(name)
    return CertifyRequest(
        group=group,
        trajectory=trajectory,
        state=world.state,
        start=trajectory.start,
        goals=trajectory.end[None],
        limits=world.limits(group),
        margins=world.margins(margin),
        jerk=False,
    )


def certificate_of(world: World, request: CertifyRequest, **changes: object) -> Certificate:
    changed = replace(request, **changes)
    return certify(for_oracle(world.drake), changed, no_hurry(30.0))[0]


def smallest_distance(world: World, trajectory: TimedTrajectory, name: str, step: float) -> float:
    """Return the smallest signed distance at samples `step` apart: a loop of its own on Drake.

    It shares nothing with the certifier: another context, positions from the samples, and Drake's
    list of pairs at each of them.
    """
    world = whole_world(world)
    group = world.group(name)
    plant, scene_graph = world.drake.plant, world.drake.scene_graph
    context = world.drake.diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    length = float(
        np.abs(
            np.diff(trajectory.positions(np.linspace(0, trajectory.duration, 200)), axis=0)
        ).sum()
    )
    count = max(50, int(length / step))
    smallest = np.inf
    for q in trajectory.positions(np.linspace(0, trajectory.duration, count)):
        plant.SetPositions(plant_context, world.embed(group, q))
        query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
        # What is farther than the nearest so far need not be measured: Drake culls it.
        pairs = query.ComputeSignedDistancePairwiseClosestPoints(min(0.5, max(0.0, smallest)))
        smallest = min([smallest, *(pair.distance for pair in pairs)])
        if query.HasCollisions():  # distances may be too large, this verdict is not (ADR 6)
            smallest = min(smallest, -1e-9)
    return smallest
