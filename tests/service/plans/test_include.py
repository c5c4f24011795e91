"""`?include=`: an answer carries the large parts of a result that were asked for, and no others."""

import pytest

from service.jobs.json_steps import STEP, members_of, without_members
from service.plans.models.result import LARGE_PARTS


@pytest.mark.parametrize("include", ["", "path", "trajectory", "certificate,stages", "stages,path"])
def test_what_is_not_asked_for_is_absent_and_the_rest_as_it_was(client, solved, include):
    whole = client.get(f"/v1/plans/{solved['id']}").json()
    told = client.get(f"/v1/plans/{solved['id']}?include={include}")
    assert told.status_code == 200, told.text
    wanted = set(filter(None, include.split(",")))
    kept = {
        name: part
        for name, part in whole["result"].items()
        if name in wanted or name not in LARGE_PARTS
    }
    assert told.json() == {**whole, "result": kept}
    assert set(LARGE_PARTS) & set(kept) == wanted


def test_a_plan_that_is_waited_for_has_the_parts_that_were_asked_for(client, solved):
    path = "/v1/plans?wait=60&include=certificate"
    told = client.post(path, json=solved["request"])
    assert told.status_code == 200
    assert set(LARGE_PARTS) & set(told.json()["result"]) == {"certificate"}
    assert told.json()["digest"] == solved["digest"]
    reverse = client.post(f"/v1/plans/{solved['id']}/reverse?wait=60&include=").json()
    assert set(LARGE_PARTS) & set(reverse["result"]) == set()


def test_a_plan_without_a_result_has_none(client, solved):
    request = solved["request"] | {"start": [0.0] * 6}
    told = client.post("/v1/plans?wait=60&include=path", json=request).json()
    assert (told["state"], told["result"]) == ("failed", None)


@pytest.mark.parametrize("include", ["trajectorie", "path,", ",", "path,path2", "PATH"])
def test_a_part_that_there_is_not_is_refused_by_name(client, solved, include):
    told = client.get(f"/v1/plans/{solved['id']}?include={include}")
    assert (told.status_code, told.json()["code"]) == (422, "unknown_name")
    assert sorted(told.json()["evidence"]["known"]) == sorted(LARGE_PARTS)


def test_large_texts_lose_members_as_small_ones_do():
    rows = ",".join(["[1.5,2.5]"] * (STEP // 4))
    text = f'{{"a":{{"x":"}},"}},\n"path":[{rows}],\n"b":[1,2],"c":null}}'
    assert without_members(text, {"path"}) == '{"a":{"x":"},"},"b":[1,2],"c":null}'
    assert dict(members_of(without_members(text, {"a", "b", "c"})))["path"] == f"[{rows}]"
    assert without_members(text, {"a", "b", "c", "path"}) == "{}"
