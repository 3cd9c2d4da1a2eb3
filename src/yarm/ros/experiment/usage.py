"""What each node costs: processor time and memory of the processes behind the ROS graph."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Dict, List, Set, Tuple

import psutil

from yarm.experiments.run.record import NodeUsage
from yarm.ros.common.graph import node_pids

MB = 1.0 / (1024.0 * 1024.0)


@dataclass(frozen=True)
class _Reading:
    cpu_s: float
    memory_mb: float


class UsageMeter:
    """Reads every node's process at the start and at the end; nodes of one process (nodelets) are one line."""

    def __init__(self) -> None:
        """Nothing is measured before ``start``."""
        self._processes: Dict[int, Tuple[str, psutil.Process]] = {}
        self._first: Dict[int, _Reading] = {}
        self._middle: Dict[int, _Reading] = {}
        self._began = time.monotonic()

    def start(self) -> None:
        """Find the processes and read them."""
        by_pid: Dict[int, Set[str]] = {}
        for node, pid in node_pids().items():
            by_pid.setdefault(pid, set()).add(node.lstrip("/"))
        self._processes = {}
        for pid, nodes in by_pid.items():
            try:
                self._processes[pid] = (_title(nodes), psutil.Process(pid))
            except psutil.NoSuchProcess:
                continue
        self._first = self._read()
        self._began = time.monotonic()

    def half_way(self) -> None:
        """Read memory half-way through a soak; only the first call counts."""
        if not self._middle:
            self._middle = self._read()

    def finish(self, camera_sets: int) -> List[NodeUsage]:
        """Cost of each process since ``start``, over this number of camera sets."""
        wall_s = max(1e-3, time.monotonic() - self._began)
        rows = []
        for pid, last in self._read().items():
            first = self._first[pid]
            used_s = last.cpu_s - first.cpu_s
            per_frame = 1000.0 * used_s / camera_sets if camera_sets else float("nan")
            title = self._processes[pid][0]
            middle = self._middle[pid].memory_mb if pid in self._middle else float("nan")
            rows.append(NodeUsage(title, used_s / wall_s, per_frame, first.memory_mb, last.memory_mb, middle))
        return rows

    def memory_mb(self) -> float:
        """Resident memory of all processes now, MB."""
        return sum(reading.memory_mb for reading in self._read().values())

    def lost(self) -> List[str]:
        """Nodes whose process has ended since ``start``."""
        return sorted(title for title, process in self._processes.values() if not process.is_running())

    def _read(self) -> Dict[int, _Reading]:
        readings = {}
        for pid, (_, process) in self._processes.items():
            try:
                times = process.cpu_times()
                readings[pid] = _Reading(times.user + times.system, process.memory_info().rss * MB)
            except psutil.NoSuchProcess:
                continue
        return readings


def _title(nodes: Set[str]) -> str:
    managers = sorted(node for node in nodes if node.endswith("manager"))
    ordered = managers + sorted(nodes - set(managers))
    return ordered[0] if len(ordered) == 1 else f"{ordered[0]} (+{len(ordered) - 1})"
