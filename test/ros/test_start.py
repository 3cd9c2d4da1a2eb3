"""A node connects to each publisher of a topic once, however many lists of publishers come at a time."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

import pytest
import rospy
from rospy.impl.masterslave import ROSHandler

from yarm.ros.common import start

LIMIT_S = 60.0
ROOT = Path(__file__).resolve().parents[2]


class Slow:
    """Connects, and holds its callers until it is told to go on; who finds a connection makes none."""

    def __init__(self):
        self.go = threading.Event()
        self.came = threading.Semaphore(0)
        self.connected = []

    def __call__(self, handler, topic, uri):
        if (topic, uri) in self.connected:
            return "already"
        self.came.release()
        assert self.go.wait(LIMIT_S)
        self.connected.append((topic, uri))
        return "connected"


def asked_together(slow, *pairs):
    """What callers are answered who ask for these topics and publishers while none is answered."""
    connect = start.one_at_a_time(slow)
    answers = []
    threads = [threading.Thread(target=lambda p=pair: answers.append(connect(None, *p))) for pair in pairs]
    for thread in threads:
        thread.start()
    for _ in set(pairs):
        assert slow.came.acquire(timeout=LIMIT_S)
    slow.go.set()
    for thread in threads:
        thread.join(LIMIT_S)
    return answers


def test_two_that_ask_for_one_publisher_make_one_connection():
    slow = Slow()
    assert sorted(asked_together(slow, *[("goal", "http://a")] * 5)) == ["already"] * 4 + ["connected"]
    assert slow.connected == [("goal", "http://a")]


def test_nobody_waits_for_another_publisher_or_another_topic():
    pairs = [("goal", "http://a"), ("goal", "http://b"), ("scan", "http://a")]
    slow = Slow()
    assert asked_together(slow, *pairs) == ["connected"] * 3
    assert sorted(slow.connected) == sorted(pairs)


def test_a_failure_is_passed_on_and_holds_nobody_up():
    def refused(handler, topic, uri):
        raise ConnectionError("refused")

    connect = start.one_at_a_time(refused)
    for _ in range(2):
        with pytest.raises(ConnectionError):
            connect(None, "goal", "http://a")


def test_rospy_is_told_once(monkeypatch):
    names = []
    monkeypatch.setattr(rospy, "init_node", lambda name, **options: names.append((name, options)))
    monkeypatch.setattr(ROSHandler, "_connect_topic", ROSHandler._connect_topic)
    start.init_node("a", anonymous=True)
    once = ROSHandler._connect_topic
    start.init_node("b")
    assert ROSHandler._connect_topic is once
    assert names == [("a", {"anonymous": True}), ("b", {})]


def test_every_node_begins_so():
    others = [
        str(file.relative_to(ROOT))
        for folder in ("src", "test", "bench", "scripts")
        for file in (ROOT / folder).rglob("*")
        if file.is_file() and file.suffix in (".py", "") and file.name not in ("start.py", "test_start.py")
        if "rospy.init_node(" in file.read_text(errors="replace")
    ]
    assert others == []


def test_a_command_without_a_master_ends_with_words(monkeypatch, capsys):
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:1")
    with pytest.raises(SystemExit) as ended:
        start.init_command("why", wait_s=0.0)
    assert ended.value.code == 2
    assert "why: no ROS master at http://localhost:1: start the system with roslaunch" in capsys.readouterr().err


def test_a_node_that_was_started_again_says_how_often_and_why():
    status = start.restarts_status("safety_monitor", "2", "killed by SIGKILL")
    assert status.name == "safety_monitor: supervision"
    assert status.level == status.WARN
    assert "2 times" in status.message
    assert "killed by SIGKILL" in status.message
    assert [value.value for value in status.values] == ["2", "killed by SIGKILL"]


SANDER_BEGINS = """
import sys
from yarm.control.sander.planner import SanderPlanner
from yarm.control.arm.model import load_arm
from yarm.robots.hc10 import AT_ORIGIN
from yarm.ros.sander.node import SanderNodeParams
SanderPlanner(load_arm(AT_ORIGIN.folded), SanderNodeParams())
print(sorted({"matplotlib.pyplot", "roslaunch", "setuptools"} & set(sys.modules)))
import matplotlib.pyplot
assert matplotlib.pyplot.figure
"""


def test_a_sander_that_is_started_again_imports_nothing_that_it_does_not_need():
    """Half of the processor time until it was back went into libraries for pictures, launching and installing."""
    command = [sys.executable, "-c", SANDER_BEGINS]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=LIMIT_S)
    assert done.stdout.splitlines()[-1:] == ["[]"], done
