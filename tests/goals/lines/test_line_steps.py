"""The bound on the deviation from a line between two of its waypoints."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.linear_moves import ToolLine
from planning.domain.robot.manifold import Manifold
from planning.goals.lines.line_steps import LineSteps
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World
from tests.goals.conftest import ENGINES, with_engine
from tests.profiles import num_cases

# The second joint and, through it, the third one follow the first.
FOLDING = """<robot name="fold"><link name="base"/><link name="a"/><link name="b"/>
<link name="tool"/>
<joint name="lead" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="fold" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<origin xyz="1 0 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
<mimic joint="lead" multiplier="{first}"/></joint>
<joint name="tip" type="revolute"><parent link="b"/><child link="tool"/><axis xyz="0 1 0"/>
<origin xyz="0.4 0 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
<mimic joint="lead" multiplier="{second}" offset="0.3"/></joint></robot>"""


@cache
def folding(engine: str, first: float, second: float) -> World:
    with TemporaryDirectory() as name:
        home = Path(name) / "fold"
        home.mkdir()
        (home / "fold.urdf").write_text(FOLDING.format(first=first, second=second))
        (home / "robot.yaml").write_text(
            "name: fold\nfile: fold.urdf\nbase: base\ndefault_group: all\n"
            "groups: {all: {joints: [lead], tool_frames: [tool]}}\n"
            "limits: {lead: {velocity: 1.0, acceleration: 1.0}}\n"
        )
        scene = planning.parse_scene({"name": "s", "robots": [{"name": "fold", "model": "fold"}]})
        library = planning.ModelLibrary((Path(name),), allow_paths=False)
        return with_engine(planning.load_world(scene, library), engine)


@ENGINES
@given(
    begin=st.floats(-1.5, 1.5),
    move=st.floats(0.05, 0.2),
    ratios=st.sampled_from([(-1.0, 0.0), (-1.0, 0.5), (-3.0, -2.0), (1.0, 0.0)]),
)
@settings(max_examples=num_cases(6))
def test_the_bound_holds_where_joints_follow_others(
    engine: str, begin: float, move: float, ratios: tuple[float, float]
) -> None:
    world = folding(engine, *ratios)
    group = world.group("fold")
    kinematics = ToolKinematics(world, group, "fold::tool")
    rows = begin + move * np.linspace(0, 1, 9)[:, None]
    poses = [Pose.from_matrix(x) for x in world.frame_poses("fold::tool", world.embed(group, rows))]
    line = ToolLine("fold::tool", poses[0], poses[-1])
    steps = LineSteps(kinematics, Manifold(group.joints), [line])
    whole = np.ones(1)
    shift, turn = steps.deviation_bounds(
        np.zeros(1, dtype=np.int64), rows[:1], rows[-1:] - rows[0], whole
    )
    strays = [
        pose.distance(line.pose(float(s)))
        for pose, s in zip(poses, np.linspace(0, 1, 9), strict=True)
    ]
    assert max(stray[0] for stray in strays) <= shift[0] + 1e-9
    assert max(stray[1] for stray in strays) <= turn[0] + 1e-9
    assert shift[0] < 20 * move**2  # what is left out is of second order
