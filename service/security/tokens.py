"""Tokens of an identity provider: JSON web tokens (RFC 7519) that OpenID Connect issues.

A token is let in if the provider signed it for this server, with a key that the provider publishes
(OpenID Connect Discovery 1.0, section 4; RFC 7517), and if it has not expired. What it is good for
its claims `scope`, `scp` or `roles` say, as `wayproof:plan`.
"""

import asyncio
import logging
from collections.abc import AsyncGenerator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from time import monotonic
from typing import Any

import httpx
import jwt

from service.security.scopes import Scope

# Of signatures with a public key: a token that says HS256, or none, proves nothing.
ALGORITHMS = ("RS256", "RS384", "RS512", "PS256", "PS384", "PS512", "ES256", "ES384", "EdDSA")
_PREFIX = "wayproof:"
_CLAIMS = ("scope", "scp", "roles")
# Which say whom a token is of, for people; the first that there is.
_NAMES = ("preferred_username", "email", "client_id", "azp")
# Clocks differ by so much [s].
_LEEWAY = 10.0
# How old keys may be, how soon those that are not known are asked for again, and how long for [s].
_LIFETIME, _PAUSE, _PATIENCE = 3600.0, 10.0, 2.0
_MAX_TOKEN = 16_384
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Token:
    """A token that was let in.

    Attributes:
        id: Whom it is of, as the provider says it (`sub`).
        name: The same for people.
        scopes: What it is good for.
        expires_at: From when it is refused.
    """

    id: str
    name: str
    scopes: frozenset[Scope]
    expires_at: datetime

    def is_valid(self, now: datetime) -> bool:
        """Return whether it has not expired."""
        return now < self.expires_at

    def allows(self, scope: Scope) -> bool:
        """Return whether it is good for a scope; `admin` is for all of them."""
        return bool(self.scopes & {scope, Scope.ADMIN})


class TokenVerifier:
    """Verifies tokens by the keys that a provider publishes, which are fetched when needed."""

    def __init__(
        self,
        issuer: str,
        audience: str,
        http: httpx.AsyncClient,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        """Verify tokens of one provider.

        Args:
            issuer: The provider, as tokens say it.
            audience: Whom they are meant for.
            http: Fetches its keys.
            clock: Seconds.
        """
        self._issuer = issuer
        self._audience = audience
        self._http = http
        self._clock = clock
        self._keys = dict[str, jwt.PyJWK]()
        self._read_at = self._tried_at = -_LIFETIME
        self._reading = asyncio.Lock()

    async def find(self, text: str) -> Token | None:
        """Return the token that a text is, None if it is none that is valid."""
        if len(text) > _MAX_TOKEN:
            return None
        try:
            header = jwt.get_unverified_header(text)
            key = await self._key(header.get("kid"))
            return None if key is None else self._verified(text, key)
        except (
            jwt.PyJWTError,
            OverflowError,
            ValueError,
            OSError,
        ):  # or an instant beyond all dates
            return None

    def _verified(self, text: str, key: jwt.PyJWK) -> Token | None:
        claims = jwt.decode(
            text,
            key,
            algorithms=[each for each in ALGORITHMS if each == key.algorithm_name],
            audience=self._audience,
            issuer=self._issuer,
            leeway=_LEEWAY,
            options={"require": ["exp", "sub", "iss", "aud"]},
        )
        name = next((claims[each] for each in _NAMES if _is_name(claims.get(each))), claims["sub"])
        expires_at = datetime.fromtimestamp(claims["exp"], UTC)
        return Token(claims["sub"], f"{name}"[:64], scopes_of(claims), expires_at)

    async def _key(self, identifier: object) -> jwt.PyJWK | None:
        """Return the key that a token names; a provider with one key may leave out which."""
        age = self._clock() - self._read_at
        if age >= _LIFETIME or identifier not in self._keys:
            await self._renew()
        if identifier is None and len(self._keys) == 1:
            return next(iter(self._keys.values()))
        return self._keys.get(identifier) if isinstance(identifier, str) else None

    async def _renew(self) -> None:
        """Fetch the keys anew, but not for each token that names one that there is not."""
        async with self._reading:
            if self._clock() - self._tried_at < _PAUSE:
                return
            self._tried_at = self._clock()
            try:
                async with asyncio.timeout(_PATIENCE):
                    self._keys = await self._fetched()
                self._read_at = self._clock()
            except (
                httpx.HTTPError,
                OSError,
                ValueError,
                KeyError,
                TypeError,
                jwt.PyJWTError,
            ) as fault:
                kind = type(fault).__name__
                _log.warning("keys of %s could not be fetched (%s)", self._issuer, kind)

    async def _fetched(self) -> dict[str, jwt.PyJWK]:
        """Return the keys that the provider publishes."""
        base = self._issuer.rstrip("/")
        described = await self._json(f"{base}/.well-known/openid-configuration")
        if described["issuer"] != self._issuer:
            message = "it says that it is another one"
            raise ValueError(message)
        published = await self._json(described["jwks_uri"])
        keys = jwt.PyJWKSet.from_dict(published).keys
        return {key.key_id or "": key for key in keys if key.algorithm_name in ALGORITHMS}

    async def _json(self, url: str) -> dict[str, Any]:
        answer = await self._http.get(url)
        answer.raise_for_status()
        found: dict[str, Any] = answer.json()
        return found


def _is_name(claim: object) -> bool:
    return isinstance(claim, str) and claim != "" and claim.isprintable()


def scopes_of(claims: Mapping[str, Any]) -> frozenset[Scope]:
    """Return what a token is good for; scopes of other programs are passed over."""
    said = set[str]()
    for name in _CLAIMS:
        claim = claims.get(name)
        if isinstance(claim, str):
            said |= set(claim.split())
        elif isinstance(claim, list):
            said |= set(map(str, claim))
    return frozenset(scope for scope in Scope if f"{_PREFIX}{scope}" in said)


@asynccontextmanager
async def open_verifier(issuer: str, audience: str) -> AsyncGenerator[TokenVerifier]:
    """Lend the verifier of a provider's tokens."""
    async with httpx.AsyncClient(timeout=_PATIENCE, follow_redirects=False) as http:
        yield TokenVerifier(issuer, audience, http)
