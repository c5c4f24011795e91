"""What is looked at before a server starts."""

from service.errors import Unguarded
from service.settings import Settings


def require_guarded(settings: Settings) -> None:
    """Go on only if keys are asked for, or only this machine can reach the server.

    Raises:
        Unguarded: Neither is so.
    """
    if settings.auth == "none" and not settings.is_loopback:
        message = (
            f"{settings.host} can be reached from other machines, and no keys are asked for: set "
            "WAYPROOF_AUTH=keys and make one by `wayproof keys create`, or WAYPROOF_AUTH=proxy if "
            "nothing but a proxy that authenticates can reach this server"
        )
        raise Unguarded(message, {"host": settings.host})
