"""Groups, and cheap analytic collision oracles."""

from collections.abc import Callable

import numpy as np
import pytest

from planning.domain.curves import motion_samples
from planning.domain.geometry.rotation import rotate
from planning.domain.request.options import SearchOptions
from planning.domain.robot.joints import Joint, JointGroup, JointLimits, JointType
from planning.domain.robot.manifold import Manifold
from planning.search.ompl.planner_list import planner_names
from planning.search.solver import SearchTask
from tests.clocks import no_hurry
from tests.profiles import PROFILE


def each_kind_of_planner(
    test: Callable[..., None], *, among: tuple[str, ...] = ("RRTConnect", "PRM", "BITstar")
) -> Callable[..., None]:
    """Run a test with a tree, a roadmap and an anytime planner; in the campaign with all."""
    names = planner_names() if PROFILE.is_campaign else list(among)
    return pytest.mark.campaign(pytest.mark.parametrize("name", names)(test))


class Oracle:
    """Collision oracle by a function of a batch; with a group whose joints wrap or float."""

    def __init__(
        self, are_free: Callable[[np.ndarray], np.ndarray], group: JointGroup | None = None
    ) -> None:
        self._are_free = are_free
        self._manifold = Manifold(() if group is None else group.joints)
        self.asked: list[np.ndarray] = []

    def is_free(self, q):
        return bool(self.are_free(q[None])[0])

    def are_free(self, qs):
        self.asked.append(np.array(qs))
        return self._are_free(qs)

    def is_motion_free(self, origin, displacement, resolution):
        motion = origin, displacement
        return motion_samples.is_motion_free(self._manifold, self.are_free, motion, resolution)

    def are_motions_free(self, origins, displacements, resolution):
        motions = origins, displacements
        return motion_samples.are_motions_free(self._manifold, self.are_free, motions, resolution)


def group_of(*kinds: JointType) -> JointGroup:
    joints = tuple(Joint(f"r::j{i}", kind) for i, kind in enumerate(kinds))
    return JointGroup("r", joints, ("r::tool",))


def limits_of(group: JointGroup, reach: float = 1.0) -> JointLimits:
    """Limits of +-reach, infinite for circles and quaternions."""
    upper = []
    for joint in group.joints:
        match joint.type:
            case JointType.CONTINUOUS:
                upper += [np.inf]
            case JointType.PLANAR:
                upper += [reach, reach, np.inf]
            case JointType.FLOATING:
                upper += [np.inf] * 4 + [reach] * 3
            case _:
                upper += [reach]
    upper = np.array(upper)
    rates = np.ones(len(group.blocks))
    blocks = tuple(indices for _, indices in group.blocks)
    return JointLimits(-upper, upper, rates, rates, rates, rates, blocks)


def beyond_wall(qs):
    """A wall across x = 0 with a gap above y = 0.6."""
    return ~((np.abs(qs[:, 0]) < 0.1) & (qs[:, 1] < 0.6))


def l_in_slit(qs):
    """An L of two bars, x, y, yaw, passes a slit of 0.3 m in a wall at x = 0."""
    bar = np.linspace(0.0, 0.4, 9)
    points = np.concatenate([
        np.stack([bar, 0 * bar], axis=1),
        np.stack([0 * bar, bar / 2], axis=1),
    ])
    c, s = np.cos(qs[:, 2])[:, None], np.sin(qs[:, 2])[:, None]
    x = qs[:, :1] + c * points[:, 0] - s * points[:, 1]
    y = qs[:, 1:2] + s * points[:, 0] + c * points[:, 1]
    return ~((np.abs(x) < 0.05) & (np.abs(y) > 0.15)).any(axis=1)


def bar_in_window(qs):
    """A bar of 1 m along its z axis passes a window of 0.5 m x 0.5 m in a wall at x = 0."""
    bar = np.zeros((11, 3))
    bar[:, 2] = np.linspace(-0.5, 0.5, 11)
    p = rotate(qs[:, None, :4], bar[None]) + qs[:, None, 4:]
    in_window = (np.abs(p[..., 1]) < 0.25) & (np.abs(p[..., 2]) < 0.25)
    return ~((np.abs(p[..., 0]) < 0.05) & ~in_window).any(axis=1)


@pytest.fixture
def plane():
    group = group_of(JointType.PRISMATIC, JointType.PRISMATIC)
    return group, limits_of(group)


@pytest.fixture
def wall():
    return Oracle(beyond_wall)


@pytest.fixture
def closed():
    return Oracle(lambda qs: np.abs(qs[:, 0]) > 0.1)


@pytest.fixture
def soon():
    return no_hurry(10.0)


@pytest.fixture
def crossing():
    """A task from the left of the wall to its right."""

    def make(seed: int = 0, resolution: float = 0.05, **options) -> SearchTask:
        return SearchTask(
            start=np.array([-0.8, -0.8]),
            goals=np.array([[0.8, -0.5], [0.8, -0.8]]),
            options=SearchOptions(**options),
            resolution=resolution,
            padding=0.0,
            seed=seed,
        )

    return make


@pytest.fixture
def make_group():
    return group_of


@pytest.fixture
def make_limits():
    return limits_of


@pytest.fixture
def make_oracle():
    return Oracle


@pytest.fixture
def slit():
    return Oracle(l_in_slit)


@pytest.fixture
def window():
    return Oracle(bar_in_window, group_of(JointType.FLOATING))
