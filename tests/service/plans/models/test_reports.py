"""The wire's reports have every field of the domain's, so that nothing is silently dropped."""

import dataclasses

import pytest

from planning.domain.goals import funnel
from planning.domain.report import certificate, search_report, stop_report
from planning.domain.report import stage_reports as report
from planning.domain.request import robustness
from service.plans.models import ik as funnel_wire
from service.plans.models import reports as wire
from service.plans.models import result
from service.plans.models import search_reports as search_wire

PAIRS = [
    (search_report.SearchReport, search_wire.SearchReport),
    (report.RefineReport, wire.RefineReport),
    (report.RetimeReport, wire.RetimeReport),
    (report.CertifyReport, wire.CertifyReport),
    (funnel.Funnel, funnel_wire.Funnel),
    (funnel.PairTally, funnel_wire.PairTally),
    (stop_report.StopReport, wire.StopReport),
    (robustness.Robustness, wire.Robustness),
    (certificate.Certificate, result.Certificate),
    (certificate.Check, result.Check),
]


# Fields of the funnel whose JSON names stay as they were.
_ON_THE_WIRE = {
    "num_samples": "tried",
    "num_samples_violating": "breaking",
    "num_goals_violating": "violating",
    "num_with_linear_moves": "approach_ok",
}


@pytest.mark.parametrize(("value", "answer"), PAIRS, ids=lambda kind: kind.__name__)
def test_fields_are_the_same(value, answer):
    names = {_ON_THE_WIRE.get(field.name, field.name) for field in dataclasses.fields(value)}
    assert set(answer.model_fields) == names
