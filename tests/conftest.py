"""What every test may use: the bundled scenes, loaded once, and a deadline."""

import os

# Before numpy: threads of a BLAS spin beside tiny matrices, and fight with other test processes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
from collections.abc import Callable
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
import pytest
from hypothesis import is_hypothesis_test

# What can be made again stays with the checkout, so that runs share it: it is not the user's.
os.environ["XDG_CACHE_HOME"] = str(Path(__file__).parents[1] / ".pytest_cache" / "caches")

import planning
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import Joint, JointGroup, JointLimits, JointType
from planning.kernel.native import native
from planning.world.world import World
from tests.clocks import no_hurry
from tests.profiles import ONLY_CAMPAIGN, PROFILE, load_hypothesis_profile

load_hypothesis_profile()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--no-kernel", action="store_true", help="as on a machine without a compiler: Drake alone"
    )


def pytest_report_header() -> str:
    return f"profile: {PROFILE.name}, seed {PROFILE.seed}"


def _excuse_what_takes_the_kernel(config: pytest.Config) -> None:
    """Ask for no share of lines on a machine without a compiler, where some cannot be run."""
    measured = config.pluginmanager.get_plugin("_cov")
    if measured is not None and native() is None:
        measured.options.cov_fail_under = 0


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--no-kernel"):
        sys.modules["planning.kernel._native"] = None
    if "WAYPROOF_NATIVE" in os.environ:  # a build with sanitizers
        (file,) = Path(os.environ["WAYPROOF_NATIVE"]).glob("_native*.so")
        spec = spec_from_file_location("planning.kernel._native", file)
        module = module_from_spec(spec)
        sys.modules["planning.kernel._native"] = module
        spec.loader.exec_module(module)
    _excuse_what_takes_the_kernel(config)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        reasons = [str(mark.kwargs.get("reason", "")) for mark in item.iter_markers("skipif")]
        left = any(reason.startswith(ONLY_CAMPAIGN) for reason in reasons)
        if left or is_hypothesis_test(getattr(item, "function", None)):
            item.add_marker(pytest.mark.campaign)


@cache
def bundled_world(name: str) -> World:
    """Return a bundled scene, loaded; it never changes, so tests share it."""
    path = planning.bundled_folder("scenes") / f"{name}.scene.yaml"
    return planning.load_world(planning.read_scene(path))


_whole: WeakKeyDictionary[World, World] = WeakKeyDictionary()


def whole_world(world: World) -> World:
    """Return a world all of whose objects are in Drake's model, for those who ask Drake alone."""
    if world not in _whole:
        _whole[world] = planning.load_world(world.scene, world.library, all_in_drake=True)
    return _whole[world]


@pytest.fixture(scope="session")
def world_of() -> Callable[[str], World]:
    return bundled_world


@pytest.fixture(scope="session")
def pickup() -> World:
    return bundled_world("ur5e_pickup")


@pytest.fixture
def urdf_world(tmp_path: Path) -> Callable[..., World]:
    """Return what loads a robot `r` from the text of a URDF, with more of a scene around it."""

    def build(urdf: str, **more: object) -> World:
        file = tmp_path / "robot.urdf"
        file.write_text(urdf)
        robot = {"name": "r", "model": str(file)}
        return planning.load_world(planning.parse_scene({"name": "t", "robots": [robot], **more}))

    return build


@pytest.fixture
def deadline() -> Deadline:
    return no_hurry()


def group_of(*types: JointType) -> JointGroup:
    """Return a group of such joints that belongs to no robot."""
    joints = tuple(Joint(f"g::j{i}", kind) for i, kind in enumerate(types))
    return JointGroup("g", joints, ())


def limits_of(
    group: JointGroup, velocity: float = 2.0, acceleration: float = 10.0, jerk: float = 100.0
) -> JointLimits:
    """Return the same rates for every block, and positions within +-20."""
    blocks = tuple(indices for _, indices in group.blocks)
    num_blocks, nq = len(blocks), group.num_positions
    return JointLimits(
        lower=np.full(nq, -20.0),
        upper=np.full(nq, 20.0),
        velocity=np.full(num_blocks, velocity),
        acceleration=np.full(num_blocks, acceleration),
        jerk=np.full(num_blocks, jerk),
        effort=np.full(num_blocks, np.inf),
        blocks=blocks,
    )


def random_waypoints(group: JointGroup, seed: int, count: int, spread: float = 0.7) -> np.ndarray:
    """Return a random walk on the group's manifold, shape (count, nq)."""
    rng = np.random.default_rng(seed)
    q = np.zeros(group.num_positions)
    offset = 0
    for joint in group.joints:
        if joint.type is JointType.FLOATING:
            q[offset] = 1.0
        offset += joint.num_positions
    from planning.domain.robot.manifold import Manifold

    manifold = Manifold(group.joints)
    rows = [q]
    for _ in range(count - 1):
        rows.append(manifold.plus(rows[-1], rng.normal(0.0, spread, manifold.num_velocities)))
    return manifold.normalized(np.stack(rows))
