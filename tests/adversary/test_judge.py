"""The attacker sees what is there: planted lies are found, cut down, and found again from JSON."""

import json
from pathlib import Path

import numpy as np
import pytest

import planning
from tests.adversary.campaign_log import CampaignLog, blocks
from tests.adversary.cases import Claim, Outcome, Setting, check_of
from tests.adversary.draws.motions import around, positions, random_motion, sample_places
from tests.adversary.draws.robots import random_robot
from tests.adversary.draws.shapes import random_shape
from tests.adversary.judge.clearance_judge import ClearanceJudge
from tests.adversary.judge.distances import distance, make_solid
from tests.adversary.judge.kinematics import pose_matrix
from tests.adversary.judge.peaks import all_peaks, rise
from tests.adversary.judge.surroundings import Look, Stage
from tests.adversary.judge.unchecked_pairs import declared
from tests.adversary.judge.witness_points import bracket
from tests.adversary.run import draw, judge
from tests.adversary.shrink import shrunk
from tests.profiles import num_cases, rng_of


@pytest.mark.campaign
def test_coal_and_support_functions_measure_the_same() -> None:
    rng = rng_of(1)
    for _ in range(num_cases(40)):
        size = float(10.0 ** rng.integers(-3, 3))
        a, b = (
            make_solid("", random_shape(rng, size), _somewhere(rng, size)[None], size)
            for _ in range(2)
        )
        gap, _ = distance(a, b, 0, size)
        low, high = bracket(a, b, 0)
        assert low - 1e-8 * size <= max(gap, 0.0) <= high + 1e-8 * size


def _somewhere(rng: np.random.Generator, size: float) -> np.ndarray:
    return pose_matrix(size * rng.normal(size=3), rng.uniform(-3, 3, size=3))


@pytest.mark.campaign
def test_links_are_where_the_product_has_them(tmp_path) -> None:
    kinds = ("revolute", "continuous", "prismatic", "planar", "fixed")
    for seed in range(num_cases(2)):
        rng = rng_of(seed)
        case = {
            "robot": random_robot(rng, kinds=kinds, mimics=0.5),
            "base": [[1, 2, 3], [0.3, 2, 1]],
        }
        setting = Setting.lay_out(case, tmp_path)
        motion = random_motion(rng, setting.robot.leaders)
        curve, stage = setting.curve(motion), Stage.of(setting)
        frames = [f"r::{link}" for link in setting.robot.shapes]
        q = curve.positions(np.array([0.7 * curve.duration]))
        (poses,) = planning.forward_kinematics(setting.world, "r", q, tuple(frames))
        placed = _placed(stage, motion, 0.7 * curve.duration)
        for frame in frames:
            assert np.allclose(
                poses[frame].matrix, placed[frame[3:]], atol=1e-9 * stage.size + 1e-9
            )


def _placed(stage: Stage, motion: dict, time: float) -> dict[str, np.ndarray]:
    pieces, local, _ = around(motion, time, 0.0, 1)
    placed = stage.robot.place(positions(motion, pieces, local), stage.base, 1)
    return {link: pose[0] for link, pose in placed.items()}


def test_an_obstacle_that_is_kept_from_the_product_is_found(tmp_path) -> None:
    found = 0
    for seed in range(6):
        case = draw("clearance", seed) | {"more": {}}
        bare = Setting.lay_out({**case, "objects": []}, tmp_path)
        setting = Setting.lay_out(case, tmp_path)
        answer = bare.ask({**case["questions"][0], "margin": 0.0})
        outcome = Outcome()
        question = {**case["questions"][0], "margin": 0.0}
        ClearanceJudge(setting, Stage.of(setting), question, outcome).hold(*answer)
        found += bool(outcome.wrong)
    assert found >= 2


def test_an_instant_that_an_answer_names_is_measured_among_many_that_seem_nearer(tmp_path) -> None:
    """Of all instants at once only some are measured; there two links overlapped by 0.1 m."""
    case = json.loads(Path(__file__).with_name("many_instants.json").read_text("utf-8"))
    setting = Setting.lay_out(case, tmp_path)
    stage, (question,) = Stage.of(setting), case["questions"]
    certificate, _ = setting.ask(question)
    check = check_of(certificate, "clearance")
    there = stage.at(question["motion"], check.time, certificate.pair)
    assert there < -0.1
    look = Look(question["margin"], declared(setting, stage), also=(check.time,))
    assert stage.worst(question["motion"], look).spare <= there


def test_rates_are_those_of_differences() -> None:
    rng = np.random.default_rng(3)
    times = np.linspace(0, 1, 200)
    values = 0.3 * times + 0.2 * (times > 0.5)
    assert rise(times, values, 0.3) == pytest.approx(0.2, abs=1e-9)
    assert rise(times, -values, 0.3) == pytest.approx(0.2, abs=1e-9)
    case = draw("rates", int(rng.integers(1000)))
    motion = case["questions"][0]["motion"]
    name, part = next(iter(motion["joints"].items()))
    assert len(part["bases"]) == len(motion["breaks"]) - 1
    assert name in case["card"]["limits"]
    pieces, local, at = sample_places(motion, 50)
    assert np.allclose(np.array(motion["breaks"])[pieces] + local, at)


def test_a_failure_is_cut_down_and_comes_back_from_json() -> None:
    case = draw("clearance", 1)

    def fails(smaller: dict) -> bool:
        return any(link["shapes"] for link in smaller["robot"]["links"])

    least = json.loads(json.dumps(shrunk(case, fails)))
    assert len(least["robot"]["joints"]) == 1
    assert sum(len(link["shapes"]) for link in least["robot"]["links"]) == 1
    assert not least["objects"]
    assert judge(least).counts["asked"] == 1


def test_peaks_count_what_follows(tmp_path) -> None:
    rng = np.random.default_rng(0)
    robot = random_robot(rng, kinds=("revolute",), links=3, mimics=1.0)
    setting = Setting.lay_out({"robot": robot}, tmp_path)
    motion = random_motion(rng, setting.robot.leaders)
    peaks = all_peaks(setting.robot, motion, 1)
    for joint in setting.robot.joints:
        leader, factor = setting.robot.factor(joint.name)
        assert peaks[joint.name, ""] == pytest.approx(abs(factor) * peaks[leader, ""])


def test_a_campaign_goes_on_where_it_ended(tmp_path) -> None:
    file, seeds = tmp_path / "log", range(35, 62)
    parts = list(blocks(seeds))
    assert [number for part in parts for number in part] == list(seeds)
    outcome = Outcome([Claim("clearance", "said", 6)], [], {"asked": 4})
    CampaignLog.read(file).put("clearance", parts[0], outcome, 1.5)
    with file.open("a") as log:
        log.write('["clearance", 40, 60, {"outc')
    again = CampaignLog.read(file)
    assert again.get("clearance", parts[0]).outcome == outcome
    assert again.get("clearance", parts[0]).seconds == 1.5
    assert again.get("clearance", parts[1]) is None
    again.put("clearance", parts[1], Outcome(), 0.1)
    assert set(CampaignLog.read(file).known) == {("clearance", 35, 40), ("clearance", 40, 60)}
