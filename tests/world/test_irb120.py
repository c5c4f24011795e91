"""The IRB 120 is where ABB's product specification says (3HAC035960-001, working range)."""

import numpy as np
import pytest

import planning

WORLD = planning.load_world(
    planning.parse_scene({"robots": [{"name": "arm", "model": "irb120"}]}), kernel=False
)
ARM = WORLD.group("arm")

# Angles of axes 2 and 3 [deg], and X and Z of the centre of the wrist [mm].
WRIST_CENTRES = [
    (0, 0, 302, 630),
    (0, -77, 0, 870),
    (0, 70, 169, 300),
    (90, -77, 580, 290),
    (110, -77, 545, 91),
    (-110, -110, -440, -50),
    (-110, 70, -67, 445),
    (-110, -77, -545, 91),
]


def wrist_centre(q: np.ndarray) -> np.ndarray:
    return 1e3 * WORLD.frame_pose("arm::link_5", WORLD.embed(ARM, q)).position


@pytest.mark.parametrize(("axis_2", "axis_3", "x", "z"), WRIST_CENTRES)
def test_the_centre_of_the_wrist_is_where_the_data_sheet_says(axis_2, axis_3, x, z) -> None:
    q = np.array([0.0, *np.deg2rad([axis_2, axis_3]), 0.7, 0.5, -0.3])
    np.testing.assert_allclose(wrist_centre(q), [x, 0.0, z], atol=1.0)


def test_the_reach_is_580_mm_and_no_more() -> None:
    q = np.random.default_rng(0).uniform(-1, 1, (2000, 6)) * np.pi
    reach = max(float(np.linalg.norm(wrist_centre(row)[:2])) for row in q)
    assert 560 < reach < 580.1


def test_the_flange_is_72_mm_from_the_wrist() -> None:
    for q in np.random.default_rng(1).uniform(-2, 2, (20, 6)):
        flange = 1e3 * WORLD.frame_pose("arm::tool0", WORLD.embed(ARM, q)).position
        assert np.linalg.norm(flange - wrist_centre(q)) == pytest.approx(72.0)


def test_ranges_and_speeds_are_those_of_the_data_sheet() -> None:
    limits = WORLD.limits(ARM)
    np.testing.assert_allclose(np.rad2deg(limits.lower), [-165, -110, -110, -160, -120, -400], 1e-5)
    np.testing.assert_allclose(np.rad2deg(limits.upper), [165, 110, 70, 160, 120, 400], 1e-5)
    np.testing.assert_allclose(np.rad2deg(limits.velocity), [250, 250, 250, 320, 320, 420], 1e-5)


def test_what_may_touch_hardly_does() -> None:
    """Shapes of links that may touch overlap by a millimetre at most, wherever the arm is."""
    q = np.random.default_rng(2).uniform(WORLD.limits(ARM).lower, WORLD.limits(ARM).upper, (300, 6))
    bare = planning.ModelLibrary.bundled().find("irb120").card.allowed_collisions
    allowed = {frozenset(f"arm::{name}" for name in pair) for pair in bare}
    plant, graph = WORLD.drake.plant, WORLD.drake.scene_graph
    context = WORLD.drake.diagram.CreateDefaultContext()
    inside = plant.GetMyMutableContextFromRoot(context)
    deepest = 0.0
    for row in WORLD.embed(ARM, q):
        plant.SetPositions(inside, row)
        query = graph.get_query_output_port().Eval(graph.GetMyContextFromRoot(context))
        for pair in allowed:
            ids = [
                plant.GetCollisionGeometriesForBody(plant.get_body(WORLD.drake.bodies[name]))
                for name in pair
            ]
            deepest = min([
                deepest,
                *(
                    query.ComputeSignedDistancePairClosestPoints(a, b).distance
                    for a in ids[0]
                    for b in ids[1]
                ),
            ])
    assert deepest > -0.001
