"""The network of a client's address, by which limits count clients."""

from __future__ import annotations

import ipaddress

IPV6_PREFIX = 64  #: bits that identify a site: a host can choose the other bits freely


def network_of(address: str) -> str:
    """Return an IPv4 address, also one mapped to IPv6, as it is, and an IPv6 address as its /64 network.

    Other texts are returned unchanged.
    """
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if isinstance(found, ipaddress.IPv4Address):
        return str(found)
    return str(found.ipv4_mapped or ipaddress.ip_network((found, IPV6_PREFIX), strict=False))
