"""An event is the same whether its data was read or is JSON still."""

import pytest

from service.jobs.job import LoggedEvent
from service.jobs.json_text import Encoded

TEXT = LoggedEvent("pln_1", 1, "stage", Encoded('{"progress":0.5}'), "now")


def test_events_are_equal_by_what_they_tell():
    read = LoggedEvent("pln_1", 1, "stage", {"progress": 0.5}, "now")
    assert read == TEXT
    assert hash(TEXT) == hash(read)
    assert TEXT.data == read.data


@pytest.mark.parametrize(
    "other",
    [
        LoggedEvent("pln_2", 1, "stage", {"progress": 0.5}, "now"),
        LoggedEvent("pln_1", 2, "stage", {"progress": 0.5}, "now"),
        LoggedEvent("pln_1", 1, "progress", {"progress": 0.5}, "now"),
        LoggedEvent("pln_1", 1, "stage", {"progress": 0.6}, "now"),
        LoggedEvent("pln_1", 1, "stage", {"progress": 0.5}, "later"),
        "pln_1",
    ],
)
def test_events_differ_by_each_of_their_parts(other):
    assert other != TEXT
