"""Health of the nodes: which are alive, what they cost, and what they say of themselves on ``/diagnostics``."""

from __future__ import annotations

import threading
import time
from dataclasses import asdict
from typing import Any, Callable, Dict, List, Mapping, Tuple

import psutil
import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from yarm.console.cell import Part
from yarm.console.pulse import Beat
from yarm.console.wire import encode
from yarm.ros.common import names
from yarm.ros.common.graph import node_pids

LEVELS = {0: "ok", 1: "warning", 2: "error", 3: "stale"}
QUIET_S = 5.0
"""Diagnostics that are older, wall time, are stale, s."""
GONE_S = 120.0
"""A node, or what one said, is forgotten after so long without it, wall time, s."""
MB = 2.0**-20


class HealthWatch:
    """Looks at the processes while somebody looks at the page. Thread-safe."""

    def __init__(self, period_s: float, beats: Callable[[], Mapping[str, Beat]]) -> None:
        """Subscribe, and look from a thread.

        Args:
            period_s: wall time between two looks at the processes.
            beats: how the topics of each node come, by its name.
        """
        self._period_s, self._beats = period_s, beats
        self._lock = threading.Lock()
        self._said: Dict[str, Tuple[float, DiagnosticStatus]] = {}
        self._seen: Dict[str, Tuple[float, psutil.Process]] = {}
        self._wanted_s = -1e9
        self._part = Part(0, encode({"kind": "health", "nodes": [], "said": []}, {}))
        self._subscriber = rospy.Subscriber(names.DIAGNOSTICS, DiagnosticArray, self._on_diagnostics, queue_size=100)
        threading.Thread(target=self._run, daemon=True).start()

    def part(self) -> Part:
        """The newest look."""
        with self._lock:
            self._wanted_s = time.monotonic()
            return self._part

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        with self._lock:
            for status in message.status:
                self._said[status.name] = (time.monotonic(), status)

    def _run(self) -> None:
        while not rospy.is_shutdown():
            time.sleep(min(1.0, self._period_s))
            now_s = time.monotonic()
            with self._lock:
                wanted = now_s - self._wanted_s < 2.0 * self._period_s
            if wanted:
                nodes = self._nodes(now_s)
                with self._lock:
                    words = {"kind": "health", "nodes": nodes, "said": self._statements(now_s)}
                    self._part = Part(self._part.version + 1, encode(words, {}))
                time.sleep(max(0.0, self._period_s - 1.0))

    def _nodes(self, now_s: float) -> List[Dict[str, Any]]:
        """Each node with its process's share of a core, and memory; one that has gone is told as such for a while."""
        try:
            pids = node_pids()
        except (rosgraph.MasterException, OSError):
            pids = {}
        for node, pid in pids.items():
            try:
                known = self._seen.get(node)
                process = known[1] if known is not None and known[1].pid == pid else psutil.Process(pid)
                self._seen[node] = (now_s, process)
            except psutil.NoSuchProcess:
                continue
        self._seen = {node: seen for node, seen in self._seen.items() if now_s - seen[0] < GONE_S}
        shares: Dict[int, Tuple[float, float]] = {}
        rows, beats = [], self._beats()
        for node, (seen_s, process) in sorted(self._seen.items()):
            alive = seen_s == now_s
            if alive and process.pid not in shares:
                shares[process.pid] = _cost(process)
            share, memory_mb = shares.get(process.pid, (0.0, 0.0))
            name = node.lstrip("/")
            beat = asdict(beats[name]) if alive and name in beats else None
            rows.append({"name": name, "alive": alive, "share": share, "memory_mb": memory_mb, "beat": beat})
        return rows

    def _statements(self, now_s: float) -> List[Dict[str, Any]]:
        self._said = {name: said for name, said in self._said.items() if now_s - said[0] < GONE_S}
        return [
            {
                "name": name,
                "level": "stale" if now_s - said_s > QUIET_S else LEVELS.get(status.level, "error"),
                "text": status.message,
                "values": [[value.key, value.value] for value in status.values],
            }
            for name, (said_s, status) in sorted(self._said.items())
        ]


def _cost(process: psutil.Process) -> Tuple[float, float]:
    """Share of a core since the last look, and resident memory, MB."""
    try:
        return round(process.cpu_percent(None) / 100.0, 3), round(process.memory_info().rss * MB, 1)
    except psutil.Error:
        return 0.0, 0.0
