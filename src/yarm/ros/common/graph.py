"""The processes behind the ROS graph, and which of them other machines can reach."""

from __future__ import annotations

import xmlrpc.client
from typing import Any, Dict, List
from urllib.parse import urlsplit

import psutil
import rosgraph
import rospy

from yarm.safety.listening import exposure

CALL_LIMIT_S = 5.0
MASTER = "/master"
EVERY_INTERFACE = ("0.0.0.0", "::")
"""Addresses of a node that was not told its own: it is asked for on this machine."""


def node_pids() -> Dict[str, int]:
    """Process number of each node of the graph that answers."""
    master = rosgraph.Master(rospy.get_name())
    pids = {node: _pid_of(uri) for node, uri in _addresses(master).items()}
    return {node: pid for node, pid in pids.items() if pid}


def _addresses(master: rosgraph.Master) -> Dict[str, str]:
    """URI of each node that the master knows; empty for one that has gone meanwhile."""
    nodes = {node for table in master.getSystemState() for _, users in table for node in users}
    found = {}
    for node in nodes:
        try:
            found[node] = str(master.lookupNode(node))
        except rosgraph.MasterException:
            found[node] = ""
    return found


def _pid_of(uri: str) -> int:
    try:
        answer: Any = xmlrpc.client.ServerProxy(uri, transport=_LimitedTransport()).getPid(rospy.get_name())
    except (OSError, xmlrpc.client.Error):
        return 0
    code, _, pid = answer
    return int(pid) if code == 1 else 0


class _LimitedTransport(xmlrpc.client.Transport):
    """A node that does not answer must not hold up who asks."""

    def make_connection(self, host):  # type: ignore[no-untyped-def]
        connection = super().make_connection(host)
        connection.timeout = CALL_LIMIT_S
        return connection


def reachable_nodes() -> List[str]:
    """A line for the master and each node that other machines can reach, or that cannot be looked at; by name."""
    master = rosgraph.Master(rospy.get_name())
    addresses = {**_addresses(master), MASTER: str(master.getUri())}
    lines = {node: _exposed(uri) for node, uri in addresses.items()}
    return [f"{node} {line}" for node, line in sorted(lines.items()) if line]


def _exposed(uri: str) -> str:
    """What is to be said of a node; empty when only this machine can reach it."""
    host = urlsplit(uri).hostname or ""
    if host not in EVERY_INTERFACE and not rosgraph.network.is_local_address(host):
        return f"runs on another machine: {host or 'unknown'}"
    pid = _pid_of(uri)
    if not pid:
        return f"cannot be looked at: nobody answers at {uri}"
    try:
        exposed = exposure(pid)
    except psutil.Error as error:
        return f"cannot be looked at: {error}"
    return f"listens on {exposed}" if exposed else ""
