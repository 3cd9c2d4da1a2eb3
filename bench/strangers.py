#!/usr/bin/env python3
"""A second publisher on every input of the cell's nodes, and every service asked for anything: who dies, who says so.

    source tools/env.sh && python3 bench/strangers.py --messages 200 --seed 1

``full_system.launch`` in real time, calibrated and with a mission going on. A stranger publishes, on every topic that a
node of the cell listens to, messages with absurd numbers, wrong lengths and unknown names (``random_messages``), in
bursts as fast as they go out, and calls every service so. Not ``/clock``: who publishes that owns the cell. Wanted, or
the exit code is 1: every node lives on as the same process, no callback and no service of a node ends with an
exception, no thread dies, and the Commander still speaks afterwards. The last line says how many messages and requests
there were.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
import xmlrpc.client
from contextlib import suppress
from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

import roslib.message
import rospy
import rosservice
from random_messages import random_message
from sim_time import await_simulated_time
from yarm.msg import CommanderStatus
from yarm.srv import StateChange, StateChangeRequest

from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.ros.experiment.launcher import Family

LEFT_OUT = ("/clock", "/rosout", "/rosout_agg", "/statistics")
OWN, NOT_OURS = "strangers", ("rosout", "strangers", "roslaunch")
UP_S, CALM_S, SERVICE_S = 240.0, 5.0, 20.0
"""Wall time in which the cell must be up; to look on afterwards; a service may take, s."""
FAULT = re.compile(
    r"bad callback|Traceback \(most|Error processing request|Exception in thread|terminate called|started again|"
    r"no sign of life|uninitialized"
)
CELL_NAMES = ("ankurbot_1", "ankurbot_2", "hc10_barc", "debris_1", "table", "ankurbot_1_ee_link", "false")
MANY = 1000


class Cell:
    """The launched cell: its nodes' processes, what they print, the topics they listen to and their services."""

    def __init__(self, port: int, scene: str, log: Path) -> None:
        """Launch it."""
        os.environ["ROS_MASTER_URI"] = f"http://localhost:{port}"
        self.log = log
        command = ["roslaunch", "-p", str(port), "--screen", "yarm", "full_system.launch", f"scene:={scene}"]
        with log.open("w") as output:
            self._child = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
        self._family = Family(self._child)

    def stop(self) -> None:
        """End all of it."""
        self._family.stop()

    def await_up(self) -> None:
        """Until the Commander may move everybody.

        Raises:
            TimeoutError: it does not come up.
        """
        deadline = time.monotonic() + UP_S
        await_simulated_time(OWN, UP_S)
        init_node(OWN)
        for state in (CommanderStatus.IDLE, CommanderStatus.STARTED, CommanderStatus.CALIBRATION, CommanderStatus.MENU):
            self._await_state(state, deadline)
            more = {"jump_state": CommanderStatus.BOUNDLESS} if state == CommanderStatus.MENU else {"next_state": True}
            answer = rospy.ServiceProxy(names.COMMANDER_STATE, StateChange)(StateChangeRequest(**more))
            if not answer.success:
                raise TimeoutError(answer.message)

    def _await_state(self, state: int, deadline: float) -> None:
        while time.monotonic() < deadline:
            try:
                status = rospy.wait_for_message(names.COMMANDER_STATUS, CommanderStatus, timeout=UP_S)
            except rospy.ROSException as error:
                raise TimeoutError(str(error)) from error
            if status.state == state and not status.busy:
                return
        raise TimeoutError(f"the Commander did not come to state {state} within {UP_S:g} s: {status}")

    def processes(self) -> Dict[str, int]:
        """Process of each node of the cell, 0 for one that does not answer."""
        nodes: Dict[str, int] = {}
        for name in sorted({node for _, listed in _state()[1] + _state()[0] for node in listed}):
            if name.strip("/").split("-")[0] not in NOT_OURS:
                try:
                    uri = rospy.get_master().lookupNode(name)[2]
                    nodes[name] = int(xmlrpc.client.ServerProxy(uri).getPid(f"/{OWN}")[2])
                except (OSError, ValueError):
                    nodes[name] = 0
        return nodes

    def faults(self) -> List[str]:
        """Lines of the output that tell of an exception, with what follows them."""
        lines = self.log.read_text(errors="replace").splitlines()
        return ["\n    ".join(lines[i : i + 14]) for i, line in enumerate(lines) if FAULT.search(line)]


def _state() -> Tuple[Any, Any, Any]:
    return tuple(rospy.get_master().getSystemState()[2])  # type: ignore[return-value]


def inputs() -> Dict[str, str]:
    """Type of each topic that a node of the cell listens to, by its name."""
    types = dict(rospy.get_master().getTopicTypes()[2])
    heard = {
        topic
        for topic, nodes in _state()[1]
        if any(node.strip("/").split("-")[0] not in NOT_OURS for node in nodes) and topic not in LEFT_OUT
    }
    return {topic: types[topic] for topic in sorted(heard) if types.get(topic, "*") != "*"}


def services() -> List[str]:
    """Services of the cell's nodes, but for those that every node has."""
    return sorted(name for name, _ in _state()[2] if not name.endswith(("get_loggers", "set_logger_level")))


def flood(rng: random.Random, messages: int) -> int:
    """So many messages on every input, in bursts; how many went out."""
    topics, sent = inputs(), 0
    publishers = {}
    for topic, kind in topics.items():
        found = roslib.message.get_message_class(kind)
        if found is not None:
            publishers[topic] = (rospy.Publisher(topic, found, queue_size=MANY), found)
    time.sleep(1.0)  # until they are connected, whoever listens
    for topic, (publisher, kind) in publishers.items():
        for _ in range(messages):
            publisher.publish(random_message(kind, rng, CELL_NAMES, rospy.get_time()))
            sent += 1
        print(f"{topic} ({kind._type}): {messages}", flush=True)
    for publisher, _ in publishers.values():
        publisher.unregister()
    return sent


def ask(rng: random.Random, requests: int) -> int:
    """So many requests of every service, each with a limit; how many were answered."""
    answered = 0
    for name in services():
        try:
            kind = rosservice.get_service_class_by_name(name)
        except rosservice.ROSServiceException:
            continue  # of a package without Python messages: perception's own nodelet manager
        proxy = rospy.ServiceProxy(name, kind)
        for _ in range(requests):
            request, done = random_message(kind._request_class, rng, CELL_NAMES, rospy.get_time()), threading.Event()
            threading.Thread(target=_call, args=(proxy, request, done), daemon=True).start()
            answered += done.wait(SERVICE_S)
        print(f"{name} ({kind._type}): {requests}", flush=True)
    return answered


def _call(proxy: Any, request: Any, done: threading.Event) -> None:
    with suppress(rospy.ServiceException):  # a service may refuse; whether it raised is in the nodes' output
        proxy(request)
    done.set()


def judge(before: Dict[str, int], after: Dict[str, int], faults: Sequence[str]) -> List[str]:
    """What is not as wanted."""
    dead = [f"{name}: its process {pid} is gone" for name, pid in before.items() if after.get(name) != pid]
    return [*dead, *faults]


def main() -> int:
    """Launch, flood, ask, look; 0 when everything lives on in silence."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--messages", type=int, default=200, help="on each topic")
    parser.add_argument("--requests", type=int, default=20, help="of each service")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scene", default="1m1ma_bin")
    parser.add_argument("--port", type=int, default=12410, help="port of the ROS master")
    parser.add_argument("--results", type=Path, default=Path("results") / "strangers")
    options = parser.parse_args()
    options.results.mkdir(parents=True, exist_ok=True)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    cell, rng = Cell(options.port, options.scene, options.results / "cell.log"), random.Random(options.seed)
    try:
        cell.await_up()
        before = cell.processes()
        sent, answered = flood(rng, options.messages), ask(rng, options.requests)
        time.sleep(CALM_S)
        told = judge(before, cell.processes(), cell.faults())
        rospy.wait_for_message(names.COMMANDER_STATUS, CommanderStatus, timeout=SERVICE_S)
    finally:
        cell.stop()
    print("\n".join([*told, f"seed {options.seed}: {sent} messages, {answered} requests answered, {len(told)} faults"]))
    return 1 if told else 0


if __name__ == "__main__":
    sys.exit(main())
