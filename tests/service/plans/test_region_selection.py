"""The files through which slots are told of regions."""

import json
import os
from pathlib import Path

import pytest

from service.jobs.json_text import Encoded
from service.plans.region_selection import SelectedRegions, regions_file

SIZE = 1_000


@pytest.fixture
def file_of(tmp_path):
    """The file of a job whose regions have a digest; there is room for three."""
    clock = iter(range(1, 1_000))

    def build(digest):
        grown = {"digest": digest, "regions": "x" * SIZE}
        outcome = Encoded(json.dumps({"result": grown, "timings": {}}))
        regions = SelectedRegions("reg", digest, outcome)
        path = Path(regions_file(tmp_path, regions, max_bytes=3 * (SIZE + 50)))
        assert json.loads(path.read_text()) == grown
        # files may be younger than a clock tells apart
        os.utime(path, (0, next(clock)))
        return path

    return build


def test_the_folder_keeps_those_that_were_asked_for_last(tmp_path, file_of):
    for digest in "abcadea":
        file_of(digest)
    assert sorted(path.stem for path in tmp_path.iterdir()) == ["a", "d", "e"]


def test_a_file_that_is_lost_is_written_again(file_of):
    file_of("a").unlink()
    file_of("a")
