"""Reports in JSON have every field of the domain's, so that nothing is silently dropped."""

import dataclasses

import pytest

from planning.domain.goals import funnel
from planning.domain.report import certificate, search_report, stop_report
from planning.domain.report import stage_reports as report
from planning.domain.request import robustness
from service.plans.models import ik as funnels
from service.plans.models import reports, result
from service.plans.models import search_reports as searches

PAIRS = [
    (search_report.SearchReport, searches.SearchReport),
    (report.RefineReport, reports.RefineReport),
    (report.RetimeReport, reports.RetimeReport),
    (report.CertifyReport, reports.CertifyReport),
    (funnel.Funnel, funnels.Funnel),
    (funnel.PairTally, funnels.CollidingPair),
    (stop_report.StopReport, reports.StopReport),
    (robustness.Robustness, reports.Robustness),
    (certificate.Certificate, result.Certificate),
    (certificate.Check, result.Check),
]


# Fields of the funnel whose JSON names stay as they were.
_IN_JSON = {
    "num_samples": "tried",
    "num_samples_violating": "breaking",
    "num_goals_violating": "violating",
    "num_with_linear_moves": "approach_ok",
}


@pytest.mark.parametrize(("value", "answer"), PAIRS, ids=lambda kind: kind.__name__)
def test_fields_are_the_same(value, answer):
    names = {_IN_JSON.get(field.name, field.name) for field in dataclasses.fields(value)}
    assert set(answer.model_fields) == names
