"""Where the studio's camera stands: robots are seen, past what stands around them."""

import numpy as np

from service.studio.drawing.camera import SeenBox, place_camera, seen_boxes

_ARM = np.array([[0, 0, z] for z in np.linspace(0.1, 0.9, 9)], dtype=float)


def box(position, size):
    pose = {"position": position, "quaternion": [1, 0, 0, 0]}
    shape = {"box": size, "pose": {"position": [0, 0, 0], "quaternion": [1, 0, 0, 0]}}
    return {"pose": pose, "shapes": [shape]}


def num_hidden(camera, boxes):
    """The points of the arm that a straight line of sight does not reach, by sampling it."""
    hidden = 0
    for point in _ARM:
        sight = point + np.linspace(0, 1, 2000)[:, None] * (camera - point)
        hidden += any(
            np.any(np.all(np.abs(sight - b.X_WB[:3, 3]) <= b.half, axis=1)) for b in boxes
        )
    return hidden


def test_without_anything_around_it_looks_from_the_front_and_above():
    camera, target = place_camera(_ARM, [])
    assert camera[0] > target[0]
    assert camera[2] > target[2]


def test_it_goes_around_a_shelf_in_front():
    shelf = seen_boxes([box([0.7, 0, 0.6], [0.02, 1.6, 1.2])])
    camera, _ = place_camera(_ARM, shelf)
    assert num_hidden(camera, shelf) == 0
    front = np.array([2.0, -1.0, 1.0])
    assert num_hidden(front, shelf) > 0  # where it would be without it


def test_a_floor_neither_hides_nor_takes_it_away():
    floor = SeenBox(np.eye(4), np.array([5.0, 5.0, 0.02]))
    with_floor, without = place_camera(_ARM, [floor]), place_camera(_ARM, [])
    np.testing.assert_array_equal(with_floor, without)


def test_what_moves_is_no_obstacle():
    moving = {**box([0.7, 0, 0.6], [0.1, 2.0, 2.0]), "pose": None}
    assert seen_boxes([moving]) == []
