"""The guide names every error code that there is, and no other."""

import re
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import service
from planning.errors import WayproofError
from service.api.error_responses import CODES
from service.jobs.errors import InternalError
from tests.golden.failures import REWRITE, with_table

GUIDE = Path(__file__).parents[3] / "docs" / "reference" / "failures.md"


def classes_below(base):
    return {base} | {leaf for child in base.__subclasses__() for leaf in classes_below(child)}


def codes():
    """Every code, of errors and of what starlette answers by itself."""
    for module in walk_packages(service.__path__, "service."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    ours = {
        kind for kind in classes_below(WayproofError) if kind.__module__.split(".")[0] != "tests"
    }
    own = {kind.__dict__["code"] for kind in ours if "code" in kind.__dict__}
    return own - {WayproofError.code} | set(CODES.values()) | {"http_error"}


def test_the_guide_names_every_code():
    rows = [line.split("|")[1] for line in GUIDE.read_text().splitlines() if line.startswith("|")]
    told = {code for row in rows for code in re.findall(r"`(\w+)`", row)}
    assert InternalError.code in codes()
    assert told == codes()


def test_the_table_is_as_it_is_generated():
    text = GUIDE.read_text()
    assert text == with_table(text), f"write it anew: {REWRITE}"
