"""Webhooks lead to public addresses only, and to the very address that was looked at."""

import asyncio
import ipaddress

import pytest

from service.errors import AddressNotAllowed
from service.webhooks.addresses import is_public, resolve

PRIVATE = (
    "127.0.0.1 127.8.9.1 10.1.2.3 172.16.0.1 192.168.1.1 169.254.169.254 100.64.0.1 0.0.0.0 "
    "224.0.0.1 240.0.0.1 255.255.255.255 198.18.0.1 192.0.2.1 ::1 :: fe80::1 fc00::1 fd12::1 "
    "ff02::1 ::ffff:127.0.0.1 ::ffff:10.0.0.1 64:ff9b::7f00:1 64:ff9b::a9fe:a9fe 2002:7f00:1:: "
    "2001:0:7f00:1:: 2001:db8::1 fec0::1"
)
PUBLIC = "93.184.216.34 8.8.8.8 2606:2800:220:1::1 ::ffff:8.8.8.8 64:ff9b::808:808 2002:808:808::"


@pytest.mark.parametrize("address", PRIVATE.split())
def test_addresses_that_the_world_does_not_reach_are_not_public(address):
    assert not is_public(ipaddress.ip_address(address))


@pytest.mark.parametrize("address", PUBLIC.split())
def test_addresses_of_hosts_in_the_world_are_public(address):
    assert is_public(ipaddress.ip_address(address))


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1", "localhost", "[::1]", "2130706433", "0x7f.1", "127.1", "0", "[::ffff:7f00:1]"],
)
def test_every_way_to_write_this_machine_is_refused(host):
    with pytest.raises(AddressNotAllowed) as refused:
        asyncio.run(resolve(f"http://{host}:8000/x", may_be_private=False))
    assert refused.value.evidence["pointer"] == "/url"


def lookup(*addresses):
    """An event loop's look at names that gives these addresses."""

    async def getaddrinfo(_, host, port, **__):
        return [(0, 0, 0, "", (address, port)) for address in addresses]

    return getaddrinfo


def test_the_connection_goes_to_the_address_that_was_looked_at(monkeypatch):
    monkeypatch.setattr(asyncio.BaseEventLoop, "getaddrinfo", lookup("93.184.216.34"))
    found = asyncio.run(resolve("https://example.org/a?b=c#d", may_be_private=False))
    assert found.url == "https://93.184.216.34:443/a?b=c"
    assert (found.host, found.name) == ("example.org", "example.org")
    monkeypatch.setattr(asyncio.BaseEventLoop, "getaddrinfo", lookup("2606:2800:220:1::1"))
    found = asyncio.run(resolve("http://example.org:81/", may_be_private=False))
    assert found.url == "http://[2606:2800:220:1::1]:81/"
    assert found.host == "example.org:81"


def test_one_private_address_of_several_is_enough_to_refuse_a_name(monkeypatch):
    both = lookup("93.184.216.34", "10.0.0.1")
    monkeypatch.setattr(asyncio.BaseEventLoop, "getaddrinfo", both)
    with pytest.raises(AddressNotAllowed):
        asyncio.run(resolve("https://example.org/", may_be_private=False))
    assert asyncio.run(resolve("https://example.org/", may_be_private=True)).name == "example.org"
