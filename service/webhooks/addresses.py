"""Where webhooks may lead: not into the network that the server stands in, unless it may.

A name is resolved, all its addresses are looked at, and the connection goes to one that was looked
at: what the name says a moment later is of no account (DNS rebinding).
"""

import asyncio
import ipaddress
import socket
from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import SplitResult, urlsplit

from service.errors import AddressNotAllowed

type _Address = ipaddress.IPv4Address | ipaddress.IPv6Address

_PORTS = {"http": 80, "https": 443}
# Addresses of IPv4 behind a translator (RFC 6052).
_NAT64 = ipaddress.IPv6Network("64:ff9b::/96")


@dataclass(frozen=True)
class Target:
    """Where a request goes.

    Attributes:
        url: With the address that was looked at in the place of the name.
        host: The `Host` header.
        name: That the certificate of a server must be for.
    """

    url: str
    host: str
    name: str


async def resolve(url: str, *, may_be_private: bool) -> Target:
    """Return where a URL leads.

    Raises:
        AddressNotAllowed: It leads where webhooks may not.
        OSError: The name has no address.
    """
    parts = urlsplit(url)
    name, port = parts.hostname or "", parts.port or _PORTS[parts.scheme]
    loop = asyncio.get_running_loop()
    found = await loop.getaddrinfo(name, port, type=socket.SOCK_STREAM)
    addresses = [ipaddress.ip_address(place[4][0]) for place in found]
    if not may_be_private:
        check_public(name, addresses)
    return Target(_with_address(parts, addresses[0], port), parts.netloc, name)


def check_public(name: str, addresses: Sequence[_Address]) -> None:
    """Go on only if all addresses of a name are public ones.

    Raises:
        AddressNotAllowed: One is not.
    """
    if not all(is_public(address) for address in addresses):
        message = (
            f"url: {name!r} leads to an address that is not public; webhooks may lead there only "
            "if the server has WAYPROOF_WEBHOOK_PRIVATE_ADDRESSES"
        )
        raise AddressNotAllowed(message, {"pointer": "/url", "host": name})


def is_public(address: _Address) -> bool:
    """Return whether an address, or the one of IPv4 that it stands for, is a public host's."""
    if isinstance(address, ipaddress.IPv6Address):
        inner = address.ipv4_mapped or address.sixtofour
        if address in _NAT64:
            inner = ipaddress.IPv4Address(int(address) & 0xFFFFFFFF)
        if address.teredo is not None or address.is_site_local:
            return False
        if inner is not None:
            return is_public(inner)
    return address.is_global and not address.is_multicast and not address.is_reserved


def _with_address(parts: SplitResult, address: _Address, port: int) -> str:
    host = f"[{address}]" if address.version == 6 else str(address)
    return parts._replace(netloc=f"{host}:{port}", fragment="").geturl()
