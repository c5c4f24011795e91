"""What the OpenAPI document says of keys: the scope of each operation, and how it is refused."""

from typing import Any

from service.api.responses import problems
from service.security.scopes import required_scope

_KEY = {
    "type": "http",
    "scheme": "bearer",
    "description": "`Authorization: Bearer wp_...`, where the server asks for keys "
    "(`WAYPROOF_AUTH=keys`). `wayproof keys create` makes one for scopes: `read`, `plan`, "
    "`execute`, and `admin` for all of them. Each operation names the one that it needs.",
}


def declare_security(document: dict[str, Any], *, is_asked: bool) -> None:
    """Say which scope of a key each operation needs, and how it is refused without.

    Args:
        document: The OpenAPI document, which is changed.
        is_asked: Whether the server asks for keys.
    """
    document["components"]["securitySchemes"] = {"key": _KEY}
    refusals = {str(status): answer for status, answer in problems(401, 429).items()}
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            scope = required_scope(method.upper(), path)
            if scope is None:
                operation["security"] = []
                continue
            needed = {"key": [str(scope)]}
            # A server that asks for no keys says so: the empty requirement is one too.
            operation["security"] = [needed] if is_asked else [needed, {}]
            answers = {**refusals, **operation["responses"]}
            operation["responses"] = dict(sorted(answers.items()))
