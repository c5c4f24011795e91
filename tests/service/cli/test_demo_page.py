"""wayproof demo --open: ends with the studio of its server, which stays until it is interrupted."""

import os
import re
import signal
import subprocess
import sys

import httpx
import pytest

from tests.profiles import only_campaign
from tests.service.servers import PLAIN, until


@only_campaign("20 s: the whole demo, and a server of its own")
@pytest.mark.slow
def test_it_ends_with_the_studio_open_until_it_is_interrupted(tmp_path):
    opened = tmp_path / "opened"
    browser = f"sh -c 'echo %s > {opened}'"
    command = [sys.executable, "-m", "service", "demo", "--open", "--speed", "20"]
    process = subprocess.Popen(
        [*command, "--out", str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"BROWSER": browser},
    )
    try:
        url = until(lambda: opened.is_file() and opened.read_text().strip())
        page = httpx.get(url, timeout=60, **PLAIN)
        assert "<title>Wayproof studio</title>" in page.text
        items = httpx.get(f"{url}/v1/scenes", timeout=60, **PLAIN).json()["items"]
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        told, asked = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 0
    (scene,) = (item["id"] for item in items)
    assert re.search(rf"ur5e_pickup · {scene}", told)
    assert url in asked
    with pytest.raises(httpx.TransportError):
        httpx.get(url, timeout=5, **PLAIN)
