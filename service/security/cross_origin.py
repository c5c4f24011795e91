"""Answers that web pages of other origins may read (CORS): those that the settings name."""

from collections.abc import Sequence

from fastapi import FastAPI
from starlette.middleware.cors import CORSMiddleware

_METHODS = ("GET", "POST", "PATCH", "DELETE")
_SENT = (
    "Authorization", "Content-Type", "Idempotency-Key", "If-Match", "If-None-Match",
    "Last-Event-ID", "Prefer", "X-Request-ID",
)  # fmt: skip
_READ = (
    "ETag", "Location", "Retry-After", "Server-Timing", "WWW-Authenticate", "X-Request-ID",
    "wayproof-interpolation", "wayproof-revision",
)  # fmt: skip


def allow_origins(app: FastAPI, origins: Sequence[str]) -> None:
    """Have browsers let pages of these origins ask, with a key but never with cookies."""
    if origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=list(origins),
            allow_methods=_METHODS,
            allow_headers=_SENT,
            expose_headers=_READ,
        )
