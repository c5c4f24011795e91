"""A browser of the studio without a page: its panels are there, and are used as a page does."""

import io
import re
import threading
from contextlib import closing, contextmanager, redirect_stdout
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import viser

from service.studio.session import Session, Terms
from tests.service.servers import until

# For what hangs [s].
_PATIENCE = 60.0
SCENES = Path(__file__).parents[3] / "scenes"


class Unseen:
    """What viser tells of a browser, but for a camera, and with the notices kept."""

    def __init__(self, server):
        self.gui, self.scene, self.atomic = server.gui, server.scene, server.atomic
        self.camera = SimpleNamespace()
        self.notices = []

    def add_notification(self, title, body, **_):
        self.notices.append(f"{title} | {body}")
        return SimpleNamespace(remove=lambda: None)


class Person:
    """Uses the panels by their labels."""

    def __init__(self, browser):
        self.browser, self.notices = browser, browser.notices
        self._gui = browser.gui

    def field(self, label, value=None):
        """The newest input or button with a label, of those that can have a value."""
        handles = [*self._gui._gui_input_handle_from_uuid.values()]
        found = [
            handle
            for handle in handles
            if getattr(handle, "label", None) == label
            and (value is None or value in getattr(handle, "options", (value,)))
            and (value is None or not isinstance(handle, viser.GuiButtonHandle))
        ]
        assert found, label
        return found[-1]

    def has(self, label):
        """Whether there is an input or button with a label."""
        handles = [*self._gui._gui_input_handle_from_uuid.values()]
        return any(getattr(handle, "label", None) == label for handle in handles)

    def set(self, label, value):
        """Type a value, or choose it."""
        self._touch(self.field(label, value), value)

    def click(self, label):
        """Press a button that is there, and wait until all is done that it does."""
        button = self.field(label)
        assert button.visible, f"{label} is not there"
        assert not button.disabled, f"{label} cannot be pressed"
        self._touch(button, True)

    def start(self, label):
        """Press a button, and go on at once."""
        threading.Thread(target=self.click, args=(label,), daemon=True).start()

    def _touch(self, handle, value):
        handle._impl.value = value
        event = SimpleNamespace(client=self.browser, client_id=0, target=handle)
        for callback in [*handle._impl.update_cb]:
            callback(event)

    def gizmo(self, name):
        """A handle in the scene."""
        return self.browser.scene._handle_from_node_name[name]

    def drag(self, gizmo, position):
        """Pull a handle somewhere, and let it go."""
        gizmo._impl.position = np.array(position)
        for phase in ("start", "update", "end"):
            for callback in [*gizmo._impl_aux.update_cb]:
                callback(SimpleNamespace(client=self.browser, target=gizmo, phase=phase))

    def folder(self, label):
        """Whether a folder with a label is there."""
        containers = [*self._gui._container_handle_from_uuid.values()]
        return any(getattr(folder, "label", None) == label for folder in containers)

    @property
    def says(self):
        """All that stands there now, without markup, line by line."""
        found = []
        for container in [*self._gui._container_handle_from_uuid.values()]:
            for child in [*getattr(container, "_children", {}).values()]:
                content = getattr(child, "content", None)
                if content is not None and child.visible:
                    found.append(content)
        return found

    def reads(self, pattern):
        """Wait until a line matches, and return its markup."""
        found = []

        def is_there():
            found[:] = [html for html in self.says if re.search(pattern, plain(html))]
            return found

        try:
            until(is_there, _PATIENCE)
        except pytest.fail.Exception:
            message = f"{pattern!r} does not come: {[*map(plain, self.says)]} {self.notices}"
            pytest.fail(message)
        return found[0]


def plain(html):
    return re.sub("<[^>]*>", "", html.replace("<br>", "\n"))


def kind_of(html):
    return re.search('data-kind="([a-z]+)"', html)[1]


@contextmanager
def studio(url):
    """A person at the studio of a server, with its first scene open."""
    with redirect_stdout(io.StringIO()):
        server = viser.ViserServer("127.0.0.1", 0, verbose=False)
    try:
        browser = Unseen(server)
        with closing(Session(browser, Terms(url, SCENES), "")):
            person = Person(browser)
            person.reads("clear there")
            yield person
    finally:
        server.stop()
