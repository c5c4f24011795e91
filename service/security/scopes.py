"""Scopes of API keys, and the one that each request needs.

It is decided by method and path alone, before anything of the body is read; a path that no resource
has needs a scope as well, so that without a key nothing can be learned from the answer.
"""

from enum import StrEnum

SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
_OPEN = frozenset({"/", "/healthz", "/readyz", "/docs", "/openapi.json"})
_ASSETS = "/docs/"
_METRICS = "/metrics"
_WEBHOOKS = "/v1/webhooks"
_EXECUTIONS = "/v1/executions"


class Scope(StrEnum):
    """What a key is good for."""

    READ = "read"  # show and list resources, stream events
    PLAN = "plan"  # post, edit and delete scenes; questions, plans, regions, own motions
    EXECUTE = "execute"  # move robots, and stop them
    ADMIN = "admin"  # metrics, webhooks, and all of the above


def required_scope(method: str, path: str) -> Scope | None:
    """Return the scope that a request needs, None if it is open to all.

    Args:
        method: Of the request.
        path: Its path, or the path of a route.
    """
    # The router's expressions end with `$`, which lets a line break at the end pass.
    path = path.removesuffix("\n")
    if path in _OPEN or path.startswith(_ASSETS):
        return None
    if path == _METRICS or _is_below(_WEBHOOKS, path):
        return Scope.ADMIN
    if method in SAFE_METHODS:
        return Scope.READ
    return Scope.EXECUTE if _is_below(_EXECUTIONS, path) else Scope.PLAN


def _is_below(collection: str, path: str) -> bool:
    return path == collection or path.startswith(f"{collection}/")
