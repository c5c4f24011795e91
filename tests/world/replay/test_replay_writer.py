"""The replay page: complete in itself, and with the motion in it."""

import base64
import re
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.world.documents.scene_file import parse_scene
from planning.world.loading.load_world import load_world
from planning.world.models.model_library import bundled_folder
from planning.world.replay.replay_writer import replay_html
from planning.world.world import World


def listening() -> dict[str, str]:
    """Return the sockets of this machine that wait for connections, and their addresses (Linux)."""
    rows = [
        row.split()
        for name in ("tcp", "tcp6")
        for row in Path(f"/proc/net/{name}").read_text().splitlines()[1:]
    ]
    return {row[9]: row[1].partition(":")[0] for row in rows if row[3] == "0A"}


# 127.0.0.1 and ::1, as /proc/net writes them.
LOOPBACK = {"0100007F", "00000000000000000000000001000000"}


def own_sockets() -> set[str]:
    found: set[str] = set()
    for link in Path("/proc/self/fd").iterdir():
        try:
            target = str(link.readlink())
        except FileNotFoundError:  # closed since the listing
            continue
        found |= set(re.findall(r"socket:\[(\d+)\]", target))
    return found


@pytest.fixture(scope="module")
def world() -> World:
    return load_world(
        parse_scene((bundled_folder("scenes") / "ur5e_pickup.scene.yaml").read_text())
    )


@pytest.fixture(scope="module")
def page(world: World) -> str:
    return replay_html(world, world.group("arm"), motion(world), frames_per_second=20.0)


def motion(world: World) -> TimedTrajectory:
    group = world.group("arm")
    start = world.positions(group)
    line = JointSpline.through(group.joints, np.array([start, start + 0.3]))
    return TimedTrajectory(line.joints, line.breaks, line.bases, line.coefficients)


def messages(page: str) -> list[bytes]:
    """Return what Meshcat is told when the page opens."""
    found = re.findall(r"data:application/octet-binary;base64,([A-Za-z0-9+/=]+)", page)
    return [base64.b64decode(text) for text in found]


def test_the_page_loads_nothing(page: str) -> None:
    assert page.lstrip().lower().startswith("<!doctype html>")
    head_and_frame = re.sub(r"<script.*?</script>", "<script>", page, flags=re.DOTALL)
    assert not re.findall(r"""(?:src|href|url)\s*[=(]\s*["']?(?!data:)\w""", head_and_frame)
    assert not re.findall(r"""<(?:script|link|img|iframe)[^>]*(?:src|href)\s*=""", page)
    assert not re.findall(r"""(?:fetch|import)\(\s*["'`](?!data:)""", page)
    assert not re.findall(r"""url\(\s*["']?https?:""", page)


def test_it_has_the_motion_of_every_link_that_moves(page: str) -> None:
    (animation,) = [m for m in messages(page) if b"set_animation" in m]
    for link in ("shoulder_link", "forearm_link", "wrist_3_link", "left_finger"):
        assert f"/bodies/arm/{link}".encode() in animation
    for still in (b"/bodies/table", b"/bodies/arm/base_link"):
        assert still not in animation
    # every frame of a second of 20, its first and last instant included, for turn and place
    num_links = animation.count(b".quaternion")
    assert num_links == animation.count(b".position") >= 8
    assert animation.count(b"\xa4time") == 2 * 21 * num_links


def test_long_motions_have_fewer_frames_a_second(world: World) -> None:
    page = replay_html(world, world.group("arm"), motion(world).time_scaled(1e9), max_frames=50)
    (animation,) = [m for m in messages(page) if b"set_animation" in m]
    assert animation.count(b"\xa4time") == 2 * 51 * animation.count(b".quaternion")


def test_it_has_the_scene_its_frames_and_the_trace(page: str) -> None:
    content = b"".join(messages(page))
    for path in (b"/bodies/table/0", b"/bodies/can/0", b"/frames/pick/0", b"/frames/place/2"):
        assert path in content
    assert b"/trace" in content
    assert b"set_property" in content


class Watching(TimedTrajectory):
    """Notes the addresses that this process listens at whenever positions are asked for."""

    seen: ClassVar[list[dict[str, str]]] = []

    def positions(self, x: np.ndarray) -> np.ndarray:
        Watching.seen.append(own_listeners())
        return super().positions(x)


def own_listeners() -> dict[str, str]:
    own = own_sockets()
    return {socket: address for socket, address in listening().items() if socket in own}


def test_no_server_stays_and_it_was_a_local_one(world: World) -> None:
    plain = motion(world)
    watching = Watching(plain.joints, plain.breaks, plain.bases, plain.coefficients)
    before = own_listeners()
    replay_html(world, world.group("arm"), watching)
    assert Watching.seen
    for during in Watching.seen:
        (address,) = (during[socket] for socket in during.keys() - before.keys())
        assert address in LOOPBACK
    assert own_listeners() == before
