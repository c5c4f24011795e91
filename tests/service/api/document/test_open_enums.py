"""The document lists all values of texts that are no enums at run time; the sources agree."""

import re
from pathlib import Path

import planning
from planning import errors as planning_errors
from planning.errors import WayproofError
from service.api.document.open_enums import NO_STAGE, STAGES
from service.jobs import errors as job_errors

ROOT = Path(planning.__file__).parents[1]
# Parts of the stage search, with times of their own.
WITHIN = {"setup", "solve", "shortcut", "interpolate", "roadmap_build", "guide"}
SAID = re.compile(r'(?:\.stage\(|\bProgress\(|in_stage\()"(\w+)"')


def stages_in_sources():
    for folder in ("planning", "service"):
        for file in (ROOT / folder).rglob("*.py"):
            yield from SAID.findall(file.read_text(encoding="utf-8"))


def test_every_stage_that_is_told_is_in_the_document():
    told = set(stages_in_sources()) - WITHIN
    assert {"goals", "search", "certify", "regions", "execute", "load"} <= told
    assert told <= set(STAGES)


def test_every_stage_of_an_error_is_in_the_document():
    kinds = [*vars(planning_errors).values(), *vars(job_errors).values()]
    errors = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, WayproofError)]
    stages = {stage for error in errors if (stage := getattr(error, "stage", None)) is not None}
    assert {"goals", "worker", ""} <= stages
    assert stages <= {*STAGES, *NO_STAGE}


def test_the_document_lists_them(document):
    schemas = document["components"]["schemas"]
    assert values_of(schemas, "Plan", "stage") == [*STAGES, *NO_STAGE]
    assert values_of(schemas, "ProgressData", "stage") == list(STAGES)
    assert "goals" in values_of(schemas, "GoalUnreachableFailure", "stage")
    assert "coverage" in values_of(schemas, "RegionsSummary", "stopped_by")
    assert "torque" in values_of(schemas, "Saving", "limit")


def values_of(schemas, model, field):
    reference = schemas[model]["properties"][field]["$ref"]
    return schemas[reference.rsplit("/", 1)[1]]["enum"]
