"""Addresses of all options, by one parser."""

import pytest

from flight_replay.simulator.server.addresses import NetworkAddress, parse_network_address


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("udpin:127.0.0.1:14550", NetworkAddress("udpin", "127.0.0.1", 14550)),
        ("udp:127.0.0.1:14550", NetworkAddress("udpin", "127.0.0.1", 14550)),
        ("UDPOUT:example.org:1", NetworkAddress("udpout", "example.org", 1)),
        ("tcp:[::1]:5760", NetworkAddress("tcp", "::1", 5760)),
        ("tcpin::0", NetworkAddress("tcpin", "", 0)),
    ],
)
def test_addresses_are_read(text: str, address: NetworkAddress) -> None:
    assert parse_network_address(text) == address


@pytest.mark.parametrize(
    "text",
    ["", "udp", "udp:14550", "http:a:80", "tcp:a:65536", "tcp:a:-1", "tcp:a:\u00b2", "tcp:a:" + "9" * 5000],
)
def test_what_is_no_address_is_none(text: str) -> None:
    assert parse_network_address(text) is None


@pytest.mark.parametrize(
    ("host", "is_loopback"),
    [("127.0.0.1", True), ("::1", True), ("LocalHost", True), ("10.0.0.1", False), ("", False)],
)
def test_loopback_is_known(host: str, is_loopback: bool) -> None:
    assert NetworkAddress("tcp", host, 1).is_loopback is is_loopback
