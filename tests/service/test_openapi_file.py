"""The committed OpenAPI document is the one that is served."""

import copy
import json

import pytest

from tests.golden.differences import differences
from tests.golden.openapi import FILE, REWRITE, changes, text_of


def test_the_committed_document_is_the_one_that_is_served(document):
    found = changes(document)
    assert found == [], f"meant? `{REWRITE}` writes the file anew"


def test_the_file_is_written_in_one_way():
    committed = FILE.read_text(encoding="utf-8")
    assert committed == text_of(json.loads(committed))


def test_a_change_is_told_by_its_pointer(document):
    changed = copy.deepcopy(document)
    plan = changed["components"]["schemas"]["PlanRequest"]
    plan["required"].append("seed")
    del plan["properties"]["margin"]
    changed["paths"]["/v1/models"]["get"]["operationId"] = "models"
    assert [line.split(" ")[0] for line in changes(changed)] == [
        "/components/schemas/PlanRequest/properties/margin",
        "/components/schemas/PlanRequest/required",
        "/paths/~1v1~1models/get/operationId",
    ]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ({"a": 1}, {"a": 1}, []),
        ({"a": [1, 2]}, {"a": [1, 3]}, [("/a/1", "is 3, was 2")]),
        ({"a": 1}, {"a": True}, [("/a", "is True, was 1")]),
        ({"a": None}, {"a": {}}, [("/a", "is an object of 0 members, was None")]),
        ({"a/b~": 1}, {}, [("/a~1b~0", "is gone, was 1")]),
        ([1], [1, 2], [("", "has 2 items, had 1")]),
    ],
)
def test_each_part_that_differs_is_told_once(old, new, told):
    assert list(differences(old, new)) == told
