"""Switch computers on through the network: Wake-on-LAN by a magic packet."""

import re
import socket

from subsea.base.errors import UserError
from subsea.stage.theatre.theatre_file import NodeTable, parse_address

TIMES = 3  # packets, as one may be lost and nothing answers


def magic_packet(mac: str) -> bytes:
    """Compose the packet: six bytes 255, then 16 times the hardware address."""
    return b"\xff" * 6 + 16 * bytes.fromhex(re.sub("[:-]", "", mac))


def wake(node: NodeTable) -> None:
    """Send the packets for a computer; a UserError if this computer's network refuses them."""
    ip, port = parse_address(node.wake)
    family = socket.AF_INET6 if ip.version == 6 else socket.AF_INET
    packet = magic_packet(node.mac)
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as sender:
            sender.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
            sender.setblocking(False)
            for _ in range(TIMES):
                sender.sendto(packet, (str(ip), port))
    except OSError as fault:
        reason = fault.strerror or str(fault)
        raise UserError(
            f"node {node.name}: cannot wake it through {node.wake} ({reason})"
        ) from fault
