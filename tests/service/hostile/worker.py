"""A worker that loads scenes as the service's do: a JSON document a line, an answer a line."""

import json
import sys
from pathlib import Path

from service.errors import status_of
from service.jobs.host_folder import set_host_folder
from service.jobs.worker.context import SilentContext
from service.jobs.worker.protocol import MessageKind, load_error
from service.jobs.worker.run_task import run_task
from service.scenes import worker as scenes
from service.scenes.tasks import LOAD_SCENE


def main():
    assert scenes.load_scene  # its import has the task carried out
    library = {"model_roots": [], "allow_paths": True}
    set_host_folder(Path(sys.argv[1]))
    for line in sys.stdin:
        payload = {"text": line, "media": "json", "library": library}
        end = run_task(LOAD_SCENE.name, json.dumps(payload), SilentContext())
        answer = {"status": 201, "text": ""}
        if end.kind is MessageKind.FAILURE:
            error = load_error(end.text)
            answer = {"status": status_of(error), "text": end.text}
        elif end.kind is MessageKind.CRASH:
            answer = {"status": 503, "text": json.dumps({"code": "crash", "detail": end.text})}
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
