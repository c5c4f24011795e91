"""One server and one browser for all tests of pages in a row; a page of its own for each."""

import pytest

from tests.browser.chromium import chromium
from tests.browser.studio_page import StudioPage
from tests.service.servers import server


@pytest.fixture(scope="package")
def studio_server(tmp_path_factory):
    with server(tmp_path_factory.mktemp("studio")) as running:
        yield running


@pytest.fixture(scope="package")
def browser():
    with chromium() as running:
        yield running


@pytest.fixture
def studio(studio_server, browser):
    """The studio, open, with its first scene."""
    with StudioPage.opened(browser, studio_server.url) as page:
        page.wait_for_goal()
        yield page
