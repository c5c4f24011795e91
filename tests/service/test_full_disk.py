"""A file that finds no room is no fault of ours, and is told so; any other is."""

import errno

import pytest
from fastapi import FastAPI
from starlette.requests import Request

from service.api import error_responses as problems


@pytest.mark.parametrize(
    ("number", "status", "code"),
    [
        (errno.ENOSPC, 503, "disk_full"),
        (errno.EDQUOT, 503, "disk_full"),
        (errno.EFBIG, 503, "disk_full"),
        (errno.EACCES, 500, "internal_error"),
    ],
)
def test_a_full_disk_is_told(number, status, code):
    app = FastAPI()
    problems.install(app)
    handlers = {kind for kind in app.exception_handlers if kind in OSError.__mro__}
    handle = app.exception_handlers[max(handlers, key=lambda kind: len(kind.__mro__))]
    answer = handle(Request({"type": "http"}), OSError(number, "why", "/a/file"))
    assert answer.status_code == status
    assert f'"code":"{code}"' in answer.body.decode()
    assert ("retry-after" in answer.headers) is (status == 503)
    assert "/a/file" not in answer.body.decode()
