"""The processes behind the ROS graph, and which of them other machines can reach."""

from __future__ import annotations

import xmlrpc.client
from typing import Any, Dict, List

import psutil
import rosgraph
import rospy

from yarm.safety.listening import exposure

CALL_LIMIT_S = 5.0
MASTER = "/master"


def node_pids() -> Dict[str, int]:
    """Process number of each node of the graph that answers."""
    master = rosgraph.Master(rospy.get_name())
    publishers, subscribers, services = master.getSystemState()
    nodes = {node for table in (publishers, subscribers, services) for _, users in table for node in users}
    pids = {}
    for node in nodes:
        pid = _pid_of(master, node)
        if pid:
            pids[node] = pid
    return pids


def _pid_of(master: rosgraph.Master, node: str) -> int:
    try:
        proxy = xmlrpc.client.ServerProxy(master.lookupNode(node), transport=_LimitedTransport())
        answer: Any = proxy.getPid(rospy.get_name())
    except (rosgraph.MasterException, OSError, xmlrpc.client.Error):
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
    """A line for the master and each node that other machines can reach, or whose sockets cannot be read; by name."""
    pids = {**node_pids(), MASTER: int(rosgraph.Master(rospy.get_name()).getPid())}
    lines = []
    for node, pid in sorted(pids.items()):
        try:
            exposed = exposure(pid)
        except psutil.Error as error:
            lines.append(f"{node}: cannot be looked at: {error}")
            continue
        if exposed:
            lines.append(f"{node} listens on {exposed}")
    return lines
