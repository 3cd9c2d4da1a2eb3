"""Ports for servers that are started a moment later, by somebody else."""

from __future__ import annotations

import random
import socket
from contextlib import suppress
from pathlib import Path
from typing import Tuple

HOST = "127.0.0.1"
LOWEST = 20000
ANY_FROM = Path("/proc/sys/net/ipv4/ip_local_port_range")
"""First and last of the ports that connections, and servers that take any port, get from the system."""
ANY = (32768, 60999)
"""The same where nobody says."""
TRIES = 100


def free_port() -> int:
    """A port nobody listens on, and, where there are others, none that the system gives to whoever takes any.

    A whole system of nodes opens hundreds of connections while another one is started, and each has a port of its own.
    """
    first, last = any_ports()
    for _ in range(TRIES):
        port = random.SystemRandom().randrange(LOWEST, 65536)
        if not first <= port <= last and is_free(port):
            return port
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


def is_free(port: int) -> bool:
    """Whether nobody listens on a port; one that was left a moment ago is free."""
    with socket.socket() as probe, suppress(OSError):
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind((HOST, port))
        return True
    return False


def any_ports() -> Tuple[int, int]:
    """First and last of the ports that the system gives."""
    with suppress(OSError, ValueError):
        first, last = map(int, ANY_FROM.read_text(encoding="ascii").split())
        return first, last
    return ANY
