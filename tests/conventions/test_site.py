"""The site: every error code, setting, operation and public name has its place in it."""

import json
import re
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml

from docs.site.error_pages import error_pages, texts
from docs.site.hook import on_page_markdown
from docs.site.http_pages import http_pages
from docs.site.schema_tables import SchemaTables
from docs.site.source_pages import source_pages
from planning import __all__ as public_names
from service.api.failures.table import EVIDENCE
from service.settings import Settings

ROOT = Path(__file__).parents[2]
API = ROOT / "docs" / "reference" / "openapi.json"


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    return dict([*http_pages(API), *error_pages(), *source_pages()])


def test_every_error_code_has_a_page_with_a_cause_and_a_fix(pages: dict[str, str]) -> None:
    codes = {error.code for error in EVIDENCE}
    assert set(texts()) == codes
    for code in codes:
        page = pages[f"reference/errors/{code}.md"]
        assert page.startswith(f"# {code}\n")
        assert re.search(r"\*\*Usual cause\.\*\* [`A-Z].*\.\n", page)
        assert re.search(r"\*\*Fix\.\*\* .*\.\n", page)
        assert f"]({code}.md)" in pages["reference/errors/index.md"]


def test_fixes_name_settings_and_commands_that_there_are(pages: dict[str, str]) -> None:
    written = json.dumps(texts())
    known = {f"WAYPROOF_{name.upper()}" for name in Settings.model_fields}
    named = set(re.findall(r"WAYPROOF_\w+", written))
    assert len(named) > 8
    assert named <= known
    for command in re.findall(r"`wayproof (\w+)", written):
        assert f"## wayproof {command}\n" in pages["reference/commands.md"]


def test_settings_operations_and_names_are_all_there(pages: dict[str, str]) -> None:
    for name in Settings.model_fields:
        assert f"`WAYPROOF_{name.upper()}`" in pages["reference/settings.md"]
    for path, item in json.loads(API.read_text())["paths"].items():
        for method in item:
            assert f"### `{method.upper()} {path}`\n" in pages["reference/http.md"]
    for name in public_names:
        assert f"## {name}\n" in pages["reference/python.md"]


def test_a_model_is_shown_once_and_a_plain_type_where_it_is_used() -> None:
    row = {"properties": {"next": {"$ref": "#/x/Row"}, "size": {"$ref": "#/x/Size"}}}
    tables = SchemaTables({"Row": row, "Size": {"type": "number", "exclusiveMinimum": 0}})
    text = tables.section("Row")
    assert text.count("## Row") == 1
    assert "| `next` | [Row](#row) |" in text
    assert "| `size` | number |" in text
    assert tables.section("Row") == ""


def test_links_out_of_the_guide_lead_to_pages_or_become_names() -> None:
    page = SimpleNamespace(file=SimpleNamespace(src_uri="how-to/a.md"))
    links = "[a](../../CONTRIBUTING.md) [b](../../tests/x.py) [c](../goals.md#d)"
    text = on_page_markdown(links, page)
    assert text == "[a](../contributing.md) `b` [c](../goals.md#d)"


def test_every_generated_page_is_in_the_navigation(pages: dict[str, str]) -> None:
    listed = json.dumps(yaml.safe_load((ROOT / "mkdocs.yml").read_text())["nav"])
    left_out = {path for path in pages if path not in listed}
    assert {path for path in left_out if not path.startswith("reference/errors/")} == set()
