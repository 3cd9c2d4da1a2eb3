"""Which sockets of a process other machines can reach: ROS 1 obeys whoever reaches one (docs/security.md)."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from typing import Optional, Tuple

import psutil


@dataclass(frozen=True)
class Listener:
    """A TCP socket that waits for connections."""

    address: str
    """IPv4 or IPv6 address that it is bound to; 0.0.0.0 or :: for every interface."""
    port: int

    @property
    def loopback(self) -> bool:
        """Whether only processes of this machine can connect."""
        address = ipaddress.ip_address(self.address.split("%")[0])
        mapped = getattr(address, "ipv4_mapped", None)
        return bool((mapped or address).is_loopback)

    def __str__(self) -> str:
        return f"[{self.address}]:{self.port}" if ":" in self.address else f"{self.address}:{self.port}"


def listeners(pid: Optional[int] = None) -> Tuple[Listener, ...]:
    """The TCP sockets on which a process listens, by port.

    Args:
        pid: of the process; the caller's own unless given.

    Raises:
        psutil.Error: there is no such process, or it belongs to another user.
    """
    sockets = psutil.Process(pid).connections("tcp")
    found = {Listener(s.laddr.ip, s.laddr.port) for s in sockets if s.status == psutil.CONN_LISTEN}
    return tuple(sorted(found, key=lambda listener: (listener.port, listener.address)))


def exposure(pid: Optional[int] = None) -> str:
    """What of a process other machines can reach, for a warning; empty when nothing is.

    Args:
        pid: as for ``listeners``.

    Raises:
        psutil.Error: as ``listeners``.
    """
    return ", ".join(str(listener) for listener in listeners(pid) if not listener.loopback)
