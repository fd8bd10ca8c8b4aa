"""Names and addresses of computers, for theatre files and keys."""

import ipaddress

# ASCII, because files are named so; `\Z`, because `$` would accept a final line break.
NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}\Z"


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
