"""Small scenes for refinement, with paths made by hand."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest

from planning.domain.curves.curve import JointSpline
from planning.domain.curves.path import JointPath
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.options import RefineOptions
from planning.refine.descents.descent import Descent
from planning.refine.refine_problem import RefineProblem
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.world.documents.scene_file import parse_scene
from planning.world.loading.load_world import load_world
from planning.world.world import World
from tests.clocks import no_hurry

PUCK = """<robot name="puck">
  <link name="base"/>
  <link name="carriage"><inertial><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="puck">
    <inertial><mass value="1"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><sphere radius="0.02"/></geometry></collision>
  </link>
  <joint name="x" type="prismatic"><parent link="base"/><child link="carriage"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="y" type="prismatic"><parent link="carriage"/><child link="puck"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
</robot>"""

# Three links of 0.3 m in a plane; the first joint turns without end.
ARM = """<robot name="arm">
  <link name="base"/>
  {links}
</robot>"""
LINK = """<link name="link{i}">
    <inertial><mass value="1"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><origin xyz="0.15 0 0"/><geometry><box size="0.26 0.04 0.04"/></geometry></collision>
  </link>
  <joint name="j{i}" type="{kind}"><parent link="{parent}"/><child link="link{i}"/>
    <origin xyz="{offset} 0 0"/><axis xyz="0 0 1"/>
    <limit {bounds} velocity="2" effort="1"/></joint>"""


@dataclass(frozen=True)
class Case:
    """A world, and the refinement request of a free path in it."""

    world: World
    request: RefineRequest

    def refined(self, seconds: float = 60.0) -> tuple[JointSpline | None, RefineReport]:
        return refine(self.world, self.request, no_hurry(seconds))

    @cached_property
    def outcome(self) -> tuple[JointSpline | None, RefineReport]:
        """The same with ample time, found once."""
        return self.refined()

    def are_free(self, qs: np.ndarray) -> np.ndarray:
        group, margins = self.request.path.group, self.request.margins
        return self.world.collision_oracle(group, margins).are_free(qs)


def case_of(world: World, group: str, waypoints: np.ndarray, **changes: object) -> Case:
    path = JointPath(world.group(group), np.array(waypoints, dtype=np.float64))
    options = {"margins": world.margins(), "options": RefineOptions(), **changes}
    request = RefineRequest(path, world.limits(path.group), **options)
    case = Case(world, request)
    fine = path.spline.positions(np.linspace(0, 1, 1001))
    assert case.are_free(fine).all(), "a path to refine must be free"
    return case


def whole_descent(problem: RefineProblem) -> Descent:
    """Return the descent from the problem's first guess, at its end."""
    descent = problem.descent(problem.fit_path(0.15))
    descent.advance()
    return descent


def puck_world(
    folder: Path,
    walls: list[tuple[list[float], list[float]]],
    idle: list[float] | None = None,
) -> World:
    """A puck of radius 0.02 on x, y in +-1, among boxes given as (size, centre).

    A second puck stands at `idle`, if that is given.
    """
    file = folder / "puck.urdf"
    file.write_text(PUCK)
    objects = [
        {"name": f"wall{i}", "shape": {"box": size}, "pose": {"position": centre}}
        for i, (size, centre) in enumerate(walls)
    ]
    robots = [{"name": "puck", "model": str(file)}]
    if idle is not None:
        robots.append({"name": "idle", "model": str(file), "base": {"position": idle}})
    return load_world(parse_scene({"robots": robots, "objects": objects}))


@pytest.fixture(scope="session")
def thin_wall(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """A path around the end of a wall 1 mm thick: far thinner than the spacing of instants."""
    world = puck_world(
        tmp_path_factory.mktemp("thin_wall"), [([0.001, 1.3, 0.2], [0.0, -0.35, 0.0])]
    )
    return case_of(world, "puck", [[-0.6, 0.1], [-0.1, 0.5], [0.1, 0.5], [0.6, 0.1]])


@pytest.fixture(scope="session")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """A three-link arm that folds to pass a post, its first joint crossing the half turn."""
    file = tmp_path_factory.mktemp("arm") / "arm.urdf"
    links = [
        LINK.format(
            i=i,
            kind="continuous" if i == 0 else "revolute",
            bounds="" if i == 0 else 'lower="-2.5" upper="2.5"',
            parent="base" if i == 0 else f"link{i - 1}",
            offset=0.0 if i == 0 else 0.3,
        )
        for i in range(3)
    ]
    file.write_text(ARM.format(links="\n".join(links)))
    post = {"name": "post", "shape": {"cylinder": {"radius": 0.05, "length": 0.3}}}
    objects = [{**post, "pose": {"position": [-0.87, 0.0, 0.0]}}]
    scene = {"robots": [{"name": "arm", "model": str(file)}], "objects": objects, "margin": 0.005}
    # Corners of neighbours meet where it folds.
    scene["allowed_collisions"] = [["arm::link0", "arm::link1"], ["arm::link1", "arm::link2"]]
    world = load_world(parse_scene(scene))
    near, far = np.pi - 0.6, -np.pi + 0.6
    waypoints = [[near, 0.2, 0.2], [near, 1.9, 0.9], [far, 1.9, 0.9], [far, -0.2, 0.2]]
    return case_of(world, "arm", waypoints)


@pytest.fixture(scope="session")
def pillar() -> Case:
    """A UR5e that lifts its hand over a pillar; its gripper is no part of the group."""
    return _over_pillar()


@pytest.fixture(scope="session")
def pillar_with_jerk() -> Case:
    return _over_pillar(limits_jerk=True)


def _over_pillar(**changes: object) -> Case:
    pose = {"position": [0.5, 0.13, 0.31]}
    pillar = {"name": "pillar", "shape": {"box": [0.12, 0.12, 0.62]}, "pose": pose}
    world = load_world(
        parse_scene({"robots": [{"name": "arm", "model": "ur5e"}], "objects": [pillar]})
    )
    home = world.configuration(world.group("arm"), "home")
    low, high = np.array([0, 0.3, 0.3, -0.6, 0, 0]), np.array([0, -0.6, 0.2, 0, 0, 0])
    pan = np.eye(6)[0]
    waypoints = [home + low - pan, home + high - pan / 2, home + high + pan / 2, home + low + pan]
    return case_of(world, "arm", waypoints, **changes)


@pytest.fixture(scope="session", params=["thin_wall", "arm", "pillar", "pillar_with_jerk"])
def case(request: pytest.FixtureRequest) -> Case:
    return request.getfixturevalue(request.param)


@pytest.fixture
def make_puck(tmp_path: Path) -> Callable[..., World]:
    return lambda walls, **extra: puck_world(tmp_path, walls, **extra)
