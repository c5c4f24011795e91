"""The files of `deploy/` are consistent, and name settings, commands and paths that there are."""

import re
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from service.cli.app import app
from service.settings import Settings

DEPLOY = Path(__file__).parents[2] / "deploy"
GUIDE = DEPLOY.parent / "docs" / "how-to" / "deployment.md"
FILES = [*sorted(DEPLOY.iterdir()), GUIDE]
COMPOSE = yaml.safe_load((DEPLOY / "compose.yaml").read_text())
OBJECTS = list(yaml.safe_load_all((DEPLOY / "kubernetes.yaml").read_text()))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_settings_that_are_named_exist(file):
    named = set(re.findall(r"WAYPROOF_[A-Z_]+", file.read_text()))
    assert named
    assert named <= {f"WAYPROOF_{name.upper()}" for name in Settings.model_fields}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_commands_that_are_named_exist(file):
    for command in set(re.findall(r"wayproof ([a-z]+)\b(?! \()", file.read_text())):
        if command in {"serve", "backup", "restore", "demo"}:
            assert CliRunner().invoke(app, [command, "--help"]).exit_code == 0
    assert "serve" in (DEPLOY / "Dockerfile").read_text()


def test_the_image_is_made_of_files_that_exist():
    text = (DEPLOY / "Dockerfile").read_text()
    named = re.findall(r"[\w.-]+\.lock", text)
    assert len(named) == 2
    assert all((DEPLOY.parent / name).is_file() for name in named)
    stages = re.findall(r"^FROM \S+(?: AS (\w+))?$", text, re.MULTILINE)
    assert set(re.findall(r"--from=(\w+)", text)) <= set(stages)


def test_services_of_compose_name_one_another():
    services = COMPOSE["services"]
    for service in services.values():
        assert set(service.get("depends_on", ())) <= set(services)
        volumes = {each.partition(":")[0] for each in service.get("volumes", ())}
        assert volumes <= set(COMPOSE["volumes"])
        assert "image" in service
        assert service["restart"] == "always"
    server = services["server"]
    assert (DEPLOY / server["build"]["context"] / server["build"]["dockerfile"]).is_file()
    assert all(port.startswith("127.0.0.1:") for port in server["ports"])
    assert server["environment"]["WAYPROOF_RAY_ADDRESS"].partition(":")[0] in services


def pods():
    return [each["spec"]["template"] for each in OBJECTS if each["kind"] == "Deployment"]


def test_objects_of_kubernetes_select_one_another():
    labels = [pod["metadata"]["labels"].items() for pod in pods()]
    for each in OBJECTS:
        assert {"apiVersion", "kind", "metadata", "spec"} <= set(each)
        selector = each["spec"].get("selector") or each["spec"]["podSelector"]
        wanted = selector.get("matchLabels", selector).items()
        assert any(wanted <= found for found in labels), each["metadata"]["name"]
    for pod in pods():
        volumes = {volume["name"] for volume in pod["spec"]["volumes"]}
        for container in pod["spec"]["containers"]:
            assert {mount["name"] for mount in container["volumeMounts"]} <= volumes
            ports = {port["name"] for port in container.get("ports", ())}
            probes = [container[probe] for probe in container if probe.endswith("Probe")]
            assert {probe["httpGet"]["port"] for probe in probes} <= ports


def test_the_head_that_is_named_is_a_service_and_its_token_is_everywhere():
    services = {each["metadata"]["name"] for each in OBJECTS if each["kind"] == "Service"}
    text = (DEPLOY / "kubernetes.yaml").read_text()
    assert set(re.findall(r"([\w-]+):6379", text)) <= services
    for pod in pods():
        (container,) = pod["spec"]["containers"]
        assert "RAY_AUTH_TOKEN" in {each["name"] for each in container["env"]}


def test_machines_that_work_have_what_the_server_looks_for():
    from service.jobs.hosts.ray_hosts import RESOURCE

    for text in (file.read_text() for file in FILES if file.name != "Dockerfile"):
        resources = re.findall(r"--resources='?(\{.*?\})", text)
        assert resources
        assert all(RESOURCE in yaml.safe_load(each) for each in resources)
