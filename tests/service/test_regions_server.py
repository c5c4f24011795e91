"""Regions in a real server: worker processes, SQLite, a cancel, and a server that is killed."""

import json
import signal

import httpx
import pytest

from tests.service.routes.test_regions import ENDLESS, REQUEST, SCENE
from tests.service.test_real_server import server, until

pytestmark = [pytest.mark.slow, pytest.mark.timeout(180)]


def asked(folder, method, path, body=None):
    url = json.loads((folder / "announce.json").read_text())["url"]
    answer = httpx.request(method, url + path, json=body, trust_env=False, timeout=60)
    assert answer.is_success, answer.text
    return answer.json()


def test_regions_survive_a_killed_server_and_a_cancel_stops_their_worker(tmp_path):
    with server(tmp_path) as (process, _):
        scene = asked(tmp_path, "POST", "/v1/scenes", SCENE)["id"]
        path = f"/v1/scenes/{scene}/regions"
        done = asked(tmp_path, "POST", f"{path}?wait=50", REQUEST)
        assert done["state"] == "succeeded"
        running = f"/v1/regions/{asked(tmp_path, 'POST', path, ENDLESS)['id']}"
        until(lambda: asked(tmp_path, "GET", running)["stage"] == "regions")
        process.send_signal(signal.SIGKILL)
        process.wait()
    with server(tmp_path):
        assert asked(tmp_path, "GET", f"/v1/regions/{done['id']}") == done
        until(lambda: asked(tmp_path, "GET", running)["state"] == "running")
        asked(tmp_path, "POST", f"{running}/cancel")
        until(lambda: asked(tmp_path, "GET", running)["state"] == "canceled", 5.0)
        goal = {"type": "configuration", "name": "beyond"}
        request = {"scene": scene, "group": "body", "goal": goal, "search": {"planner": "GCS"}}
        plan = asked(tmp_path, "POST", "/v1/plans?wait=30", request)
        assert plan["result"]["stages"]["search"]["regions"]["digest"] == done["summary"]["digest"]
