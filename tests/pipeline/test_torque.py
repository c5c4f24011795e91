"""Plans under torque limits: certified, explained, with the mass of attached objects."""

from typing import Any

import numpy as np
import pytest

import planning
from planning import scene_document
from planning.api.motion_series import motion_series
from planning.domain.goals.goal import JointGoal
from planning.domain.report.certificate import Certificate, Check
from planning.domain.report.motion_plan import MotionPlan
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import RefineOptions, RetimeOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.robot.payload import Payload
from planning.errors import ProblemInvalid, RetimingFailed
from planning.world.mechanics.dynamics import GroupDynamics
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

WORLD = bundled_world("panda_shelf")
PANDA = WORLD.group("panda")
SEVEN = Payload.from_parts("panda::panda_hand", 7.0, (0.0, 0.0, 0.1))


def solve(retime: RetimeOptions, **more: object) -> MotionPlan:
    start = WORLD.positions(PANDA)
    goal = JointGoal((start + np.array([0.6, 0.1, 0.3, 0.1, 0.5, 0.1, 0.4]))[None])
    search = SearchOptions(allowed_planning_time=30.0)
    problem = PlanningProblem("panda", goal, retime=retime, search=search, **more)
    return planning.plan(problem, WORLD, deadline=within(30.0))


def within(seconds: float) -> Deadline:
    return no_hurry(seconds)


def torque_of(certificate: Certificate) -> Check:
    return next(check for check in certificate.checks if check.name == "torque")


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_a_plan_with_a_payload_keeps_torques_and_says_so(method: str) -> None:
    free = solve(RetimeOptions(method=method))
    loaded = solve(RetimeOptions(method=method, effort=True, payload=SEVEN))
    check = torque_of(loaded.certificate)
    assert loaded.certificate.proven
    assert 0.9 < check.value <= 1
    assert check.where.startswith("panda::")
    report = loaded.stages.retime
    assert report.utilisation["torque"] == pytest.approx(check.value, rel=3e-3)
    assert loaded.trajectory.duration >= free.trajectory.duration * (1 - 1e-3)
    assert "torque" not in {entry.name for entry in free.certificate.checks}
    too_quick = planning.certify_trajectory(
        WORLD,
        "panda",
        loaded.trajectory.time_scaled(1 / 1.05),
        deadline=within(10.0),
        options=RetimeOptions(method=method, effort=True, payload=SEVEN),
    )[0]
    assert not torque_of(too_quick).passed


@pytest.mark.campaign
@pytest.mark.parametrize("method", ["toppra", "ruckig"][: num_cases(1, 2)])
def test_an_explanation_names_the_joint_whose_torque_binds(method: str) -> None:
    plan = solve(RetimeOptions(method=method, effort=True, payload=SEVEN, explain=True))
    explained = plan.stages.retime.explanation
    assert explained is not None
    assert all(entry.limit and entry.share > 0 for entry in explained.intervals)
    bound = {entry.where for entry in explained.intervals if entry.limit == "torque"}
    assert plan.stages.retime.binding["torque"] in bound
    assert any(saving.limit == "torque" for saving in explained.savings)


def test_without_efforts_a_payload_changes_no_byte() -> None:
    plain, carrying = solve(RetimeOptions()), solve(RetimeOptions(payload=SEVEN))
    assert plain.digest == carrying.digest


def test_what_cannot_be_held_is_refused_with_the_joint() -> None:
    heavy = Payload.from_parts("panda::panda_hand", 40.0)
    with pytest.raises(RetimingFailed) as refusal:
        solve(RetimeOptions(effort=True, payload=heavy), refine=RefineOptions("none"))
    evidence = refusal.value.evidence
    assert evidence["where"] in {joint.name for joint in PANDA.joints}
    assert evidence["torque"] > evidence["bound"]
    assert 0 <= evidence["at"] <= 1
    with pytest.raises(ProblemInvalid, match="does not move"):
        solve(RetimeOptions(payload=Payload.from_parts("panda::panda_link0", 1.0)))


def held(mass: float | None) -> World:
    scene = planning.read_scene(planning.bundled_folder("scenes") / "ur5e_pickup.scene.yaml")
    document = scene_document(scene).model_dump()
    can = next(entry for entry in document["objects"] if entry["name"] == "can")
    can["mass"] = mass
    grasp = planning.AttachObject(
        "can", "arm::tcp", pose=planning.Pose.from_parts((0.0, 0.0, 0.01), rpy=(np.pi, 0.0, 0.0))
    )
    return planning.load_world(planning.edit_scene(planning.parse_scene(document), [grasp]))


def test_what_is_held_burdens_in_the_proof_and_in_the_plot() -> None:
    four = Payload.from_parts("can", 4.0)
    worlds = held(None), held(4.0)
    start = worlds[0].positions(worlds[0].group("arm"))
    motion = planning.retime_path(
        worlds[1],
        "arm",
        np.array([start, start + 0.2]),
        deadline=within(20.0),
        options=RetimeOptions(effort=True),
    ).trajectory
    peaks, plots = [], []
    for world, payload in ((worlds[0], None), (worlds[1], None), (worlds[0], four)):
        options = RetimeOptions(effort=True, payload=payload)
        found, _ = planning.certify_trajectory(
            world, "arm", motion, deadline=within(20.0), options=options
        )
        peaks.append(torque_of(found).value)
        series = motion_series(world, "arm", motion, 31, options)
        plots.append(series.utilisation["torque"].max())
    assert peaks[1] > 1.2 * peaks[0]
    # A point instead of a can: the same weight, a little less inertia.
    assert peaks[2] == pytest.approx(peaks[1], rel=0.01)
    assert plots == pytest.approx(peaks, rel=0.03)


def test_what_limits_a_motion_is_built_once_for_all_that_is_timed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[GroupDynamics] = []
    build = GroupDynamics.__init__

    def counted(dynamics: GroupDynamics, *args: Any) -> None:
        made.append(dynamics)
        build(dynamics, *args)

    monkeypatch.setattr(GroupDynamics, "__init__", counted)
    retime = RetimeOptions(effort=True, payload=SEVEN, duration=4.0)
    found = solve(retime, refine=RefineOptions("none"))
    assert found.certificate.proven
    assert len(made) == 1
