"""Callers: who a bearer token stands for, an API key or a token of an identity provider."""

from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from service.security.key_ring import KeyRing, open_key_ring
from service.security.keys import ApiKey
from service.settings import Settings

if TYPE_CHECKING:
    from service.security.tokens import Token, TokenVerifier

type Caller = "ApiKey | Token"


class Callers:
    """Finds the callers of requests.

    Attributes:
        keys: API keys.
        verifier: Of tokens; None if there is no identity provider.
    """

    def __init__(self, keys: KeyRing, verifier: "TokenVerifier | None" = None) -> None:
        """Know keys, and tokens if there is a provider of them."""
        self.keys = keys
        self.verifier = verifier

    async def find(self, text: str) -> "Caller | None":
        """Return the caller of a bearer token, None if it is not valid."""
        # A token has two dots, a key has none: neither is looked for among the others.
        if self.verifier is not None and "." in text:
            return await self.verifier.find(text)
        return await self.keys.find(text)

    def is_good(self, caller: "Caller") -> bool:
        """Return whether a caller that was found is still one, as far as is known."""
        if isinstance(caller, ApiKey):
            return self.keys.is_good(caller)
        return caller.is_valid(datetime.now(UTC))


@asynccontextmanager
async def open_callers(settings: Settings) -> AsyncGenerator[Callers]:
    """Lend the callers that settings let in."""
    async with open_key_ring(settings.url) as keys:
        if settings.oidc_issuer is None or settings.oidc_audience is None:
            yield Callers(keys)
            return
        from service.security.tokens import open_verifier  # noqa: PLC0415  (an extra)

        async with open_verifier(settings.oidc_issuer, settings.oidc_audience) as verifier:
            yield Callers(keys, verifier)
