"""Addresses of computers: an IP address and a port."""

import ipaddress


def parse_address(address: str) -> tuple[ipaddress.IPv4Address | ipaddress.IPv6Address, int]:
    """Parse an IP address with a port, such as ``127.0.0.1:5560``; ValueError for host names."""
    host, _, port = address.rpartition(":")
    try:
        if not port.isascii() or not port.isdecimal() or not 1 <= int(port) <= 65535:
            raise ValueError
        return ipaddress.ip_address(host.strip("[]")), int(port)
    except ValueError:
        raise ValueError(
            f"address {address!r}: expected an IP address and a port, such as 127.0.0.1:5560"
        ) from None
