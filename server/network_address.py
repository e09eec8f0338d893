"""The network of a client's address, which limits use to count clients."""

from __future__ import annotations

import ipaddress
import re
import socket

IPV6_PREFIX = 64  #: bits that identify a site; a host can choose the others freely


def network_of(address: str) -> str:
    """Return an IPv4 address, even one mapped to IPv6, unchanged, and an IPv6 address as its /64 network.

    Other texts are returned unchanged.
    """
    try:
        parsed = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if isinstance(parsed, ipaddress.IPv4Address):
        return str(parsed)
    return str(parsed.ipv4_mapped or ipaddress.ip_network((parsed, IPV6_PREFIX), strict=False))


def own_address() -> str | None:
    """Return this machine's address in its network, at which other machines reach it; None without a network.

    It connects a UDP socket, for which nothing is sent: the system chooses the address from which it would send.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # of TEST-NET-1 (RFC 5737), which is not assigned
        except OSError:
            return None
        address = str(probe.getsockname()[0])
    return None if ipaddress.ip_address(address).is_loopback else address


def reachable(netloc: str) -> str:
    """Return the host and port of a URL, with a loopback name replaced by this machine's address in its network."""
    name, colon, port = netloc.rpartition(":") if re.search(r":[0-9]+$", netloc) else (netloc, "", "")
    if name.strip("[]") not in ("localhost", "127.0.0.1", "::1", "0.0.0.0", "::"):  # noqa: S104 - compared, not bound
        return netloc
    return f"{own_address() or name}{colon}{port}"


def is_loopback_name(host: str) -> bool:
    """Return whether a name or an address is a loopback address, without name resolution."""
    name = host.strip("[]").lower()
    if name == "localhost" or name.endswith(".localhost"):
        return True
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return False
