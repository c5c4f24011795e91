"""The studio while its server is gone, and once it is back."""

import os
import re
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.browser.studio_page import StudioPage
from tests.profiles import only_campaign
from tests.service.servers import living, server

pytestmark = [
    only_campaign("a minute without a graphics card"),
    pytest.mark.campaign,
    pytest.mark.timeout(900),  # drawn by a busy processor, twice
]


@contextmanager
def attached_to(url):
    """`wayproof studio URL`, and where it is."""
    command = [sys.executable, "-m", "service", "studio", url, "--port", "0"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=dict(os.environ))
    try:
        yield re.search(r"http://127\.0\.0\.1:\d+$", process.stderr.readline().strip())[0]
    finally:
        process.kill()
        process.communicate()


def port_of(running):
    return int(running.url.rpartition(":")[2])


def test_the_page_tells_that_its_server_is_gone_and_opens_again_with_it(tmp_path, browser):
    with server(tmp_path) as running, StudioPage.opened(browser, running.url) as page:
        page.wait_for_goal()
        page.faults_are_expected = True  # of what it asks in vain
        running.kill()
        page.wait_for("The server does not answer")
        with server(tmp_path, port=port_of(running)):
            page.page.locator("#wayproof-away").wait_for(state="detached")
            page.wait_for_goal()
            page.click("Plan")
            page.wait_for("Proven")


def test_an_attached_page_tells_that_the_server_is_gone_and_goes_on_with_it(tmp_path, browser):
    with (
        server(tmp_path) as running,
        attached_to(running.url) as url,
        StudioPage.opened(browser, url) as page,
    ):
        page.wait_for_goal()
        running.kill()
        page.wait_for("The page goes on once it does.")
        with server(tmp_path, port=port_of(running)):
            page.page.get_by_text("The page goes on once it does.").wait_for(state="detached")
            page.click("Plan")
            page.wait_for("Proven")


def test_the_studio_comes_back_by_itself_when_its_process_has_died(studio, studio_server):
    # the server stays; the page connects again and gets a process anew
    (child,) = processes_of_studios(studio_server.process.pid)
    os.kill(child, 9)
    studio.page.locator("[data-kind=good]").first.wait_for(state="detached")
    studio.wait_for_goal()
    (other,) = processes_of_studios(studio_server.process.pid)
    assert other != child


def processes_of_studios(parent):
    return [
        pid
        for pid, above in living().items()
        if above == parent and b"service.studio" in Path(f"/proc/{pid}/cmdline").read_bytes()
    ]
