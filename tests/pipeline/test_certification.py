"""The first proven motion is taken; the refused ones before it are evidence."""

from types import SimpleNamespace
from typing import Any

import pytest

from planning.errors import NotCertified
from planning.pipeline.certification import Refusals, first_certified


def certificate(*failed: str) -> Any:
    checks = [
        SimpleNamespace(name=name, value=2.0, bound=1.0, unit="1", where="", time=0.0)
        for name in failed
    ]
    return SimpleNamespace(proven=not failed, failed=checks)


def no_trajectory(_: str) -> Any:
    return None


def test_the_first_that_is_proven_is_taken_and_no_other_is_looked_at() -> None:
    tried: list[str] = []
    made = iter([("a", "jerk"), ("b", ""), ("c", "")])

    def certify(failed: str) -> tuple[Any, Any]:
        tried.append(failed)
        return certificate(*filter(None, [failed])), "report"

    refusals = Refusals()
    motion, proof, report = first_certified(made, certify, no_trajectory, refusals)
    assert (motion, proof.proven, report) == ("", True, "report")
    assert tried == ["jerk", ""]
    assert refusals.reasons == ["a: jerk"]
    assert list(made) == [("c", "")]


def test_refusals_of_all_rounds_are_the_evidence_and_a_hopeless_one_ends_the_round() -> None:
    def certify(failed: str) -> tuple[Any, Any]:
        return certificate(failed), None

    refusals = Refusals()
    with pytest.raises(NotCertified):
        first_certified([("a", "jerk"), ("b", "torque")], certify, no_trajectory, refusals)
    left = iter([("c", "stop"), ("d", "jerk")])
    with pytest.raises(NotCertified) as caught:
        first_certified(
            left, certify, no_trajectory, refusals, lambda c: c.failed[0].name == "stop"
        )
    assert caught.value.evidence["refused"] == ["a: jerk", "b: torque", "c: stop"]
    assert [check["name"] for check in caught.value.evidence["checks"]] == ["stop"]
    assert list(left) == [("d", "jerk")]
