"""The server as a whole: light, self-documenting, and problems for everything unknown."""

import inspect
import re
import subprocess
import sys

import pytest

import planning
from service import app
from service.workers import PRELOAD, serves_with_processes

LIGHT = """
import sys
import planning
from service.app import create_app
create_app()
heavy = sorted(name for name in ("pydrake", "ompl", "toppra", "ruckig") if name in sys.modules)
print(",".join(heavy))
"""


def test_server_process_loads_no_engine():
    run = subprocess.run([sys.executable, "-c", LIGHT], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == ""


WARM = """
import importlib, sys
from types import SimpleNamespace
from service.jobs.worker.run_task import run_task
from service.workers import PRELOAD, WARM_UP
for name in PRELOAD:
    importlib.import_module(name)
print(run_task(WARM_UP, "{}", SimpleNamespace(is_canceled=bool)).text)
print([name for name in ("scipy", "matplotlib", "trimesh") if name in sys.modules])
"""


def test_a_worker_is_warm_without_what_few_plans_need():
    """They take longer to import than all of Drake."""
    run = subprocess.run([sys.executable, "-c", WARM], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines() == ['{"proven":true}', "[]"]


def test_entry_point_imports_nothing_until_it_runs():
    code = "import sys, service.__main__; print('fastapi' in sys.modules, 'typer' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["False", "False"]


@pytest.mark.parametrize(
    ("imports", "absent"),
    [
        ("service.workers, service.__main__", "asyncio pydantic numpy typer"),
        ("service.jobs.worker.main", "sqlalchemy fastapi numpy"),
        (", ".join(PRELOAD), "sqlalchemy alembic fastapi uvicorn service.jobs.service"),
    ],
)
def test_what_workers_begin_with_is_light(imports, absent):
    """All of it is imported at each start, before the server is ready."""
    code = f"import sys, {imports}; print(*(n for n in {absent.split()} if n in sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == []


@pytest.mark.parametrize(
    ("command", "environment", "expected"),
    [
        ("serve", {}, True),
        ("serve --port 0", {"WAYPROOF_ENGINE": "process"}, True),
        ("serve", {"WAYPROOF_ENGINE": "inline"}, False),
        ("serve --engine process", {"WAYPROOF_ENGINE": "ray"}, True),
        ("serve --engine=inline", {}, False),
        ("serve --engine ray", {}, False),
        ("serve --engine", {}, False),
        ("serve --help", {}, False),
        ("plan", {}, False),
        ("", {}, False),
    ],
)
def test_workers_begin_to_import_before_the_settings_are_read(command, environment, expected):
    assert serves_with_processes(command.split(), environment) is expected


def test_nothing_that_endpoints_are_handed_takes_a_thread():
    """FastAPI carries out what is not asynchronous in a thread: a tenth of a millisecond each."""

    def handed(dependant):
        for further in dependant.dependencies:
            yield further.call
            yield from handed(further)

    routes = [route for part in app.PARTS for route in part.router.routes]
    found = {call for route in routes for call in handed(route.dependant)}
    assert len(found) > 5
    for call in found:
        assert inspect.iscoroutinefunction(call), call


def test_health(client):
    answer = client.get("/healthz")
    assert answer.status_code == 200
    assert answer.json()["status"] == "ok"
    assert answer.json()["kernel"] == planning.kernel_name()


def test_readiness(client):
    answer = client.get("/readyz")
    assert answer.status_code == 200
    assert set(answer.json()["queued"]) == {"plan", "query", "execution", "regions"}


def test_the_servers_address_leads_to_its_documentation(client):
    page = client.get("/")
    assert page.status_code == 200
    assert page.url.path == "/docs"
    assert [step.status_code for step in page.history] == [307]


def test_docs_need_no_other_host(client):
    page = client.get("/docs")
    assert page.status_code == 200
    assert page.headers["content-type"].startswith("text/html")
    assert not re.findall(r"https?://|(?:src|href)=\"//", page.text)
    # The page would have another host check the document, and browsers are told to ask no other.
    assert re.search(r'"validatorUrl": null', page.text)
    policy = page.headers["content-security-policy"]
    assert {word for word in policy.replace(";", " ").split() if ":" in word} == {"data:"}
    assets = re.findall(r"(?:src|href)=\"([^\"]+)", page.text)
    assert {asset.rpartition(".")[2] for asset in assets} == {"js", "css", "png"}
    for asset in assets:
        answer = client.get(page.url.join(asset).path)
        assert answer.status_code == 200
        assert len(answer.content) > 1000
    assert client.get("/docs/__init__.py").status_code == 422


@pytest.mark.parametrize("path", ["/v2", "/v1", "/v1/scenes/", "/v1/nothing", "/v1/plans/x/y"])
def test_unknown_paths_are_problems(client, path):
    answer = client.get(path)
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["code"] == "not_found"


@pytest.mark.parametrize(
    ("path", "allowed"),
    [
        ("/v1/plans", "GET, POST"),
        ("/v1/scenes/x", "DELETE, GET, PATCH"),
        ("/v1/plans/x/cancel", "POST"),
        ("/healthz", "GET"),
    ],
)
def test_wrong_methods_are_problems_that_name_the_right_ones(client, path, allowed):
    answer = client.put(path)
    assert answer.status_code == 405
    assert answer.json()["code"] == "method_not_allowed"
    assert answer.headers["allow"] == allowed


def test_metrics_count_jobs(client, solved):
    text = client.get("/metrics").text
    found = re.search(
        r'^wayproof_jobs\{queue="plan",state="succeeded"\} (\d+)\.0$', text, re.MULTILINE
    )
    assert found
    assert int(found[1]) >= 1
    assert "# TYPE wayproof_jobs gauge" in text
