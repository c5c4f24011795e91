"""A host for tasks that a test calls itself: its folder, and artifacts put there by hand."""

from contextvars import copy_context

from service.jobs.artifacts import Artifact
from service.jobs.host_folder import artifact_path, set_host_folder


def on_host(folder, work, *args):
    """Call a task as if a worker of a host with that folder did."""

    def call():
        set_host_folder(folder)
        return work(*args)

    return copy_context().run(call)


def put(folder, content):
    """Have a copy of an artifact in the folder of a host; return its digest."""
    digest = Artifact(content).digest
    path = artifact_path(folder, digest)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return digest
