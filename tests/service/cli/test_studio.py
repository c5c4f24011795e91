"""wayproof studio: the page of any server, for this machine alone."""

import re
import subprocess
import sys

import httpx
import pytest

from tests.service.servers import PLAIN


@pytest.fixture(scope="module")
def url():
    command = [sys.executable, "-m", "service", "studio", "http://127.0.0.1:9", "--port", "0"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        greeting = process.stderr.readline()
        assert "the studio of http://127.0.0.1:9 is at" in greeting
        yield re.search(r"http://127\.0\.0\.1:\d+$", greeting.strip())[0]
    finally:
        process.kill()
        process.communicate()


def test_it_serves_the_page_on_loopback(url):
    # it waits in the queue of the socket until the server takes it
    page = httpx.get(url, timeout=60, **PLAIN)
    assert page.status_code == 200
    assert "<title>Wayproof studio</title>" in page.text
    assert page.headers["x-frame-options"] == "DENY"


@pytest.mark.parametrize("header", [{"Host": "evil.example"}, {"Origin": "https://evil.example"}])
def test_pages_of_others_do_not_get_it(url, header):
    assert httpx.get(url, timeout=60, headers=header, **PLAIN).status_code in {400, 403}
