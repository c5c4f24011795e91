"""How far a plan's start is from where the robot is."""

import math

import pytest

from service.executions.position import separation
from service.scenes.models.summary import Group, Joint


def group(*types):
    joints = [Joint(name=f"j{i}", type=kind) for i, kind in enumerate(types)]
    return Group.model_construct(joints=joints)


@pytest.mark.parametrize(
    ("types", "a", "b", "distance"),
    [
        (("revolute", "prismatic"), [0.0, 1.0], [0.1, 1.3], 0.3),
        (("revolute",), [0.0], [2 * math.pi], 2 * math.pi),
        (("continuous",), [0.1], [0.1 + 2 * math.pi], 0.0),
        (("continuous",), [-3.1], [3.1], 2 * math.pi - 6.2),
        (("planar",), [0.0, 0.0, 0.0], [0.1, 0.0, 2 * math.pi - 0.2], 0.2),
        (("floating",), [1, 0, 0, 0, 0, 0, 0], [-1, 0, 0, 0, 0, 0, 0.5], 0.5),
        (
            ("floating", "revolute"),
            [1, 0, 0, 0, 0, 0, 0, 0],
            [math.cos(0.3), 0, 0, math.sin(0.3), 0, 0, 0, 0.1],
            0.6,
        ),
    ],
)
def test_separation_is_on_the_manifold(types, a, b, distance):
    assert separation(group(*types), a, b) == pytest.approx(distance, abs=1e-9)
