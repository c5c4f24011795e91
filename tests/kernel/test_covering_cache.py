"""Coverings on disk: found again, and never trusted blindly."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from planning.kernel.coverings.covering import (
    VERSION,
    Covering,
    cached_covering,
    cover,
    stored_covering,
)
from planning.kernel.shape import ConvexShape, ShapeKind
from tests.kernel.bodies import body, hull

SHAPE = hull(3, 12, 0.1, 0.2, 0.05)
OTHER = body(ShapeKind.CYLINDER, 0.1, 0.2, 0.0)


@pytest.fixture(autouse=True)
def _only_with_kernel() -> None:
    """Coverings need no native code."""


made = cache(cover)


def from_disk(folder: Path) -> Covering:
    """Return what another process would get, which must not compute it."""

    def refuse(_: ConvexShape) -> Covering:
        pytest.fail("computed again")

    return stored_covering(SHAPE, folder, refuse)


def test_a_covering_is_found_again_bit_for_bit(tmp_path: Path) -> None:
    folder = tmp_path / "not" / "there"
    first = stored_covering(SHAPE, folder)
    assert first == made(SHAPE)
    assert len(list(folder.iterdir())) == 1
    assert from_disk(folder) == first


def test_it_is_read_once_and_remembered(tmp_path: Path) -> None:
    first = cached_covering(SHAPE, tmp_path)
    (file,) = tmp_path.iterdir()
    file.unlink()
    assert cached_covering(SHAPE, tmp_path) is first
    assert not list(tmp_path.iterdir())


def only_file(folder: Path) -> Path:
    stored_covering(SHAPE, folder, made)
    (file,) = folder.iterdir()
    return file


def with_radius(text: str, radius: float) -> str:
    document = json.loads(text)
    document["outer"][0][3] = radius
    return json.dumps(document)


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: "",
        lambda text: text[: len(text) // 2],
        lambda text: "[]",
        lambda text: "null",
        lambda text: '"outer"',
        lambda text: text.replace('"outer"', '"other"'),
        lambda text: with_radius(text, 0.001),
        lambda text: with_radius(text, 10**400),
        lambda text: text.replace('"seal": "', '"seal": "0'),
        lambda text: "[" * 100_000,
        lambda text: "\x00\xff" * 10,
    ],
)
def test_a_damaged_file_is_made_anew(damage: object, tmp_path: Path) -> None:
    file = only_file(tmp_path)
    text = file.read_text()
    assert callable(damage)
    file.write_bytes(damage(text).encode("latin-1"))
    assert stored_covering(SHAPE, tmp_path, made) == made(SHAPE)
    assert file.read_text() == text
    assert from_disk(tmp_path) == made(SHAPE)


def test_the_covering_of_another_shape_is_not_taken(tmp_path: Path) -> None:
    file = only_file(tmp_path / "one")
    stored_covering(OTHER, tmp_path / "two", made)
    (other,) = (tmp_path / "two").iterdir()
    file.write_text(other.read_text())
    assert stored_covering(SHAPE, tmp_path / "one", made) == made(SHAPE)


def test_a_folder_that_cannot_be_written_to_is_no_fault(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert stored_covering(SHAPE, tmp_path / "file" / "folder", made) == made(SHAPE)


def test_a_folder_in_the_way_of_the_file_is_no_fault(tmp_path: Path) -> None:
    file = only_file(tmp_path)
    file.unlink()
    (file / "more").mkdir(parents=True)
    assert stored_covering(SHAPE, tmp_path, made) == made(SHAPE)
    assert [f for f in tmp_path.iterdir() if f != file] == []


def test_without_a_folder_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cached_covering(SHAPE, None) == made(SHAPE)
    assert not list(tmp_path.iterdir())


def test_another_version_is_not_read(tmp_path: Path) -> None:
    mark = Covering(np.ones((1, 4)), np.zeros((0, 4)), np.ones(4), 0.5)
    stored_covering(SHAPE, tmp_path, lambda _: mark, VERSION - 1)
    assert stored_covering(SHAPE, tmp_path, made) == made(SHAPE)
    assert stored_covering(SHAPE, tmp_path, made, VERSION - 1) == mark
