"""Roadmap cache: the last used stays, files outlive processes, damaged files count as misses."""

import json
import os
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.planner.roadmap import Roadmap
from planning.roadmaps.roadmap_cache import RoadmapCache
from tests.profiles import num_cases

KEYS = "abcdefghij"


def make(key="a", count=5, seed=0):
    rng = np.random.default_rng(seed)
    edges = np.array([(i, j) for i in range(count) for j in range(i + 1, count)], dtype=np.int32)
    return Roadmap(key, rng.normal(size=(count, 3)), edges.reshape(-1, 2), 17)


@settings(max_examples=num_cases(6))
@given(count=st.integers(0, 9), seed=st.integers(0, 99))
def test_a_file_gives_back_every_bit(tmp_path_factory, count, seed):
    folder = tmp_path_factory.mktemp("shelf")
    roadmap = make(count=count, seed=seed)
    RoadmapCache(folder=folder).put(roadmap)
    found = RoadmapCache(folder=folder).get("a")
    assert found == roadmap
    assert found.digest == roadmap.digest
    assert found.states.tobytes() == roadmap.states.tobytes()
    assert not found.states.flags.writeable
    assert not found.edges.flags.writeable


def test_a_roadmap_pickles_and_stays_frozen():
    roadmap = make()
    again = pickle.loads(pickle.dumps(roadmap))
    assert again == roadmap
    assert again.edges.dtype == np.int32
    with pytest.raises(ValueError, match="read-only"):
        again.edges[0] = 3


def corrupted(text: str):
    document = json.loads(text)
    yield ""
    yield text[: len(text) // 2]
    yield "[]"
    yield "[" * 100_000
    yield json.dumps(document | {"key": "b"})
    yield json.dumps(document | {"states": document["states"][:-4]})
    yield json.dumps(document | {"states": "AAAA" + document["states"][4:]})
    yield json.dumps(document | {"edges": document["edges"][:-1] + "?"})
    yield json.dumps(document | {"size": [3, 5]})
    yield json.dumps(document | {"num_states_checked": "many"})
    yield json.dumps(document | {"num_states_checked": None})
    yield json.dumps({name: item for name, item in document.items() if name != "edges"})


def test_what_was_tampered_with_is_not_there(tmp_path):
    roadmap = make()
    RoadmapCache(folder=tmp_path).put(roadmap)
    (file,) = tmp_path.glob("*.json")
    for text in list(corrupted(file.read_text())):
        file.write_text(text)
        assert RoadmapCache(folder=tmp_path).get("a") is None, text[:80]
    RoadmapCache(folder=tmp_path).put(roadmap)
    assert RoadmapCache(folder=tmp_path).get("a") == roadmap


def test_the_last_used_stay_in_memory():
    a, b, c = (make(key) for key in "abc")
    shelf = RoadmapCache([a, b], max_bytes=2 * a.num_bytes)
    assert shelf.get("a") is a
    shelf.put(c)
    assert shelf.get("b") is None
    assert shelf.get("a") is a
    assert shelf.get("c") is c
    tight = RoadmapCache([a, b], max_bytes=0)
    assert tight.get("b") is b
    assert tight.get("a") is None


@pytest.mark.parametrize(("most_bytes", "num_left"), [(3_000, 1), (9_000, 3)])
def test_of_a_folder_that_is_full_the_oldest_files_go(tmp_path, most_bytes, num_left):
    """A file has 2,828 bytes."""
    shelf = RoadmapCache(folder=tmp_path, max_bytes_on_disk=most_bytes)
    for at, key in enumerate(KEYS):
        shelf.put(make(key, count=20))
        os.utime(tmp_path / f"{key}.json", (at, at))
    sizes = [file.stat().st_size for file in tmp_path.iterdir()]
    assert sum(sizes) <= most_bytes
    assert len(sizes) == num_left
    kept = [key for key in KEYS if RoadmapCache(folder=tmp_path).get(key) is not None]
    assert kept == list(KEYS[10 - num_left :])


def test_a_folder_that_cannot_be_written_is_no_failure(tmp_path):
    blocker = tmp_path / "file"
    blocker.write_text("")
    shelf = RoadmapCache(folder=blocker / "below")
    shelf.put(make())
    assert shelf.get("a") == make()
    assert RoadmapCache(folder=blocker / "below").get("a") is None
