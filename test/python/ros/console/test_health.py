"""What the page is told of each node's process: alive, its share of a core, its memory, and that it has gone."""

from __future__ import annotations

import subprocess
import sys
import time
from typing import Any, Dict, Iterator

import psutil
import pytest
import rospy

from yarm.console.pulse import Beat
from yarm.ros.console import health
from yarm.ros.console.health import GONE_S, HealthWatch

BUSY = "kept = bytearray(100_000_000)\nkept[::4096] = b'x' * len(kept[::4096])\nprint(flush=True)\nwhile True: pass"
MB_KEPT = 95.0
LIMIT_S = 60.0


@pytest.fixture(name="busy")
def busy_fixture() -> Iterator[subprocess.Popen]:
    with subprocess.Popen([sys.executable, "-c", BUSY], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        yield process
        process.kill()


def worked(process: subprocess.Popen) -> None:
    """Until a process has had a tenth of a second more of a core."""
    known = psutil.Process(process.pid)
    from_s, until_s = known.cpu_times().user, time.monotonic() + LIMIT_S
    while known.cpu_times().user < from_s + 0.1:
        assert time.monotonic() < until_s, "the process gets no time"
        time.sleep(0.02)


def test_a_node_is_told_with_what_it_costs_and_once_it_has_gone_as_gone(
    busy: subprocess.Popen, monkeypatch: pytest.MonkeyPatch
) -> None:
    pids: Dict[str, int] = {"/busy": busy.pid, "/its_nodelet": busy.pid, "/never_there": 2**22 + 1}
    beat = Beat("status", 10.0, 12.0, 20.0)
    monkeypatch.setattr(health, "node_pids", lambda: pids)
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    watch = HealthWatch(1e9, lambda: {"busy": beat})

    def look(now_s: float) -> Dict[str, Dict[str, Any]]:
        return {row["name"]: row for row in watch._nodes(now_s)}

    look(1.0)
    worked(busy)
    rows = look(2.0)
    assert set(rows) == {"busy", "its_nodelet"}, "a process that is not there is no node"
    for row in rows.values():
        assert row["alive"] and 0.0 < row["share"] < 1.5 and MB_KEPT < row["memory_mb"] < 2.0 * MB_KEPT
    assert rows["busy"]["beat"] is not None and rows["its_nodelet"]["beat"] is None
    pids.clear()
    for row in look(3.0).values():
        assert (row["alive"], row["share"], row["memory_mb"], row["beat"]) == (False, 0.0, 0.0, None)
    assert look(2.0 + GONE_S) == {}


def test_a_node_that_came_back_is_another_process(busy: subprocess.Popen, monkeypatch: pytest.MonkeyPatch) -> None:
    pids = {"/node": psutil.Process().pid}
    monkeypatch.setattr(health, "node_pids", lambda: pids)
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    watch = HealthWatch(1e9, dict)
    watch._nodes(1.0)
    pids["/node"] = busy.pid
    watch._nodes(2.0)
    assert watch._seen["/node"][1].pid == busy.pid
