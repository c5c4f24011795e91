"""Every query of the Grafana dashboard names metrics, and labels, that /metrics has."""

import json
import re
from collections import defaultdict
from pathlib import Path
from types import SimpleNamespace

import pytest
from prometheus_client.parser import text_string_to_metric_families

from service.api.metrics import Metrics
from service.jobs.dispatch.scheduling.scheduler import QueueLoad

DASHBOARD = json.loads((Path(__file__).parents[2] / "ops/grafana/wayproof.json").read_text())
PANELS = DASHBOARD["panels"]
QUERIES = [target["expr"] for panel in PANELS for target in panel["targets"]]
# Prometheus says by itself whom it asked, and histograms their bounds.
GIVEN = {"instance", "job"}


@pytest.fixture(scope="module")
def labels():
    """The labels of each metric that a server shows once it has done something of every kind."""
    metrics = Metrics()
    metrics.note_request({"method": "GET"}, 200, 0.1)
    metrics.note_assignment("plan", 0.1, was_warm=True)
    metrics.note_crash("plan", "SIGSEGV")
    failure = {"code": "no_path_found", "timings": {"search": 1.0}}
    metrics.note_end(SimpleNamespace(queue="plan", failure=failure, result=None))
    text = metrics.exposition({"queued": {"plan": 1}}, {"plan": QueueLoad(1, 1, 1)})
    found = defaultdict(set)
    for family in text_string_to_metric_families(text):
        for sample in family.samples:
            found[sample.name] |= set(sample.labels)
    return found


@pytest.mark.parametrize("query", QUERIES)
def test_queries_name_what_is_there(query, labels):
    named = re.findall(r"(wayproof_\w+)(?:\{([^}]*)\})?", query)
    assert named
    assert query.count("(") == query.count(")")
    grouped = {name for group in re.findall(r"by \(([^)]*)\)", query) for name in group.split(", ")}
    for metric, selectors in named:
        assert metric in labels
        chosen = set(re.findall(r"(\w+)\s*(?:=~|!=|!~|=)", selectors))
        assert chosen | grouped <= labels[metric] | GIVEN


def test_nothing_that_is_counted_is_left_out(labels):
    shown = {name for query in QUERIES for name in re.findall(r"wayproof_\w+", query)}
    whole = {re.sub(r"_(bucket|count|sum|total)$", "", name) for name in shown}
    assert whole == {re.sub(r"_(bucket|count|sum|total)$", "", name) for name in labels}


def test_legends_have_labels_of_their_queries():
    for panel in PANELS:
        for target in panel["targets"]:
            named = set(re.findall(r"\{\{(\w+)\}\}", target["legendFormat"]))
            groups = re.findall(r"by \(([^)]*)\)", target["expr"])
            assert all(named <= set(group.split(", ")) for group in groups)


def test_panels_do_not_lie_on_one_another():
    places = [tuple(panel["gridPos"][side] for side in "xy") for panel in PANELS]
    assert len(set(places)) == len(places)
    assert len({panel["id"] for panel in PANELS}) == len(PANELS)
