"""Coverings on disk: found again, and never trusted blindly."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from planning.kernel import covering
from planning.kernel.covering import Covering, cached_covering, cover
from planning.kernel.shape import ShapeKind
from tests.kernel.bodies import body, hull

SHAPE = hull(3, 12, 0.1, 0.2, 0.05)
OTHER = body(ShapeKind.CYLINDER, 0.1, 0.2, 0.0)


@pytest.fixture(autouse=True)
def _only_with_kernel() -> None:
    """Coverings need no native code."""


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    covering._remembered.cache_clear()
    yield
    covering._remembered.cache_clear()


def from_disk(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Covering:
    """Return what another process would get, which must not compute it."""
    covering._remembered.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(covering, "cover", lambda _: pytest.fail("computed again"))
        return cached_covering(SHAPE, folder)


def test_a_covering_is_found_again_bit_for_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "not" / "there"
    first = cached_covering(SHAPE, folder)
    assert first == cover(SHAPE)
    assert len(list(folder.iterdir())) == 1
    assert from_disk(monkeypatch, folder) == first


def only_file(folder: Path) -> Path:
    cached_covering(SHAPE, folder)
    covering._remembered.cache_clear()
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
def test_a_damaged_file_is_made_anew(
    damage: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = only_file(tmp_path)
    text = file.read_text()
    assert callable(damage)
    file.write_bytes(damage(text).encode("latin-1"))
    assert cached_covering(SHAPE, tmp_path) == cover(SHAPE)
    assert file.read_text() == text
    assert from_disk(monkeypatch, tmp_path) == cover(SHAPE)


def test_the_covering_of_another_shape_is_not_taken(tmp_path: Path) -> None:
    file = only_file(tmp_path / "one")
    cached_covering(OTHER, tmp_path / "two")
    (other,) = (tmp_path / "two").iterdir()
    file.write_text(other.read_text())
    assert cached_covering(SHAPE, tmp_path / "one") == cover(SHAPE)


def test_a_folder_that_cannot_be_written_to_is_no_fault(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert cached_covering(SHAPE, tmp_path / "file" / "folder") == cover(SHAPE)


def test_a_folder_in_the_way_of_the_file_is_no_fault(tmp_path: Path) -> None:
    file = only_file(tmp_path)
    file.unlink()
    (file / "more").mkdir(parents=True)
    assert cached_covering(SHAPE, tmp_path) == cover(SHAPE)
    assert [f for f in tmp_path.iterdir() if f != file] == []


def test_without_a_folder_nothing_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(covering, "_write", lambda *_: pytest.fail("written"))
    assert cached_covering(SHAPE, None) == cover(SHAPE)


def test_another_version_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cached_covering(SHAPE, tmp_path)
    covering._remembered.cache_clear()
    mark = Covering(np.ones((1, 4)), np.zeros((0, 4)), np.ones(4), 0.5)
    monkeypatch.setattr(covering, "_VERSION", -1)
    monkeypatch.setattr(covering, "cover", lambda _: mark)
    assert cached_covering(SHAPE, tmp_path) == mark
