#!/usr/bin/env python3
"""Who can be reached from other machines: the node itself says it, network_check finds it, and passes the others."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Dict, List

import rosgraph
import rostest

from yarm.ros.common.graph import node_pids
from yarm.ros.common.start import init_node
from yarm.safety.listening import listeners

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
GATE = [sys.executable, str(SCRIPTS / "velocity_gate")]
AMCL = ["rosrun", "yarm", "amcl"]
NODES = {
    "inside": (GATE, "localhost"),
    "outside": (GATE, "0.0.0.0"),
    "cpp_inside": (AMCL, "localhost"),
    "cpp_outside": (AMCL, "0.0.0.0"),
}


class NetworkTest(ListeningTest):
    """Two nodes alike in Python, of which one listens on every interface, and two in C++."""

    @classmethod
    def setUpClass(cls):
        cls.listen()
        cls.said = {name: tempfile.NamedTemporaryFile() for name in NODES}  # noqa: SIM115 (closed with the class)
        cls.nodes = [cls.begin(name, *NODES[name]) for name in NODES]

    @classmethod
    def tearDownClass(cls):
        for node in cls.nodes:
            node.terminate()
        for node in cls.nodes:
            node.wait(cls.limit_s)
        for file in cls.said.values():
            file.close()

    @classmethod
    def begin(cls, name: str, command: List[str], address: str) -> subprocess.Popen:
        return subprocess.Popen(
            [*command, f"__name:={name}"],
            stdout=cls.said[name],
            stderr=subprocess.STDOUT,
            env={**os.environ, "ROS_HOSTNAME": address},
        )

    def test_1_the_check_names_who_can_be_reached_and_where(self):
        pids = self.ask(self.all_nodes, "the processes of all nodes")
        said = self.check()
        for name in ("outside", "cpp_outside"):
            lines = [line for line in said if line.startswith(f"/{name} ")]
            self.assertEqual(len(lines), 1, said)
            ports = [listener.port for listener in listeners(pids[f"/{name}"])]
            self.assertGreaterEqual(len(ports), 2, name)
            for port in ports:
                self.assertIn(f"0.0.0.0:{port}", lines[0])
        for name in ("inside", "cpp_inside", "master"):
            self.assertFalse([line for line in said if line.startswith(f"/{name} ")], said)

    def test_2_whoever_cannot_be_looked_at_is_named_too(self):
        for name, uri in (("/gone", "http://localhost:1/"), ("/far", "http://203.0.113.7:1/")):
            rosgraph.Master(name).registerPublisher("/nothing", "std_msgs/Empty", uri)
        said = self.check()
        self.assertIn("/gone cannot be looked at: nobody answers at http://localhost:1/", said)
        self.assertIn("/far runs on another machine: 203.0.113.7", said)

    def test_3_the_node_says_it_itself(self):
        said = self.ask(lambda: self.warnings("outside"), "a warning of the node that can be reached")
        self.assertIn("ROS_HOSTNAME=localhost", said[0])
        self.assertEqual(self.warnings("inside"), [])

    def all_nodes(self) -> Dict[str, int]:
        pids = node_pids()
        return pids if {f"/{name}" for name in NODES} <= set(pids) else {}

    def check(self) -> List[str]:
        done = subprocess.run(
            [sys.executable, str(SCRIPTS / "network_check")],
            check=False,
            stdout=subprocess.PIPE,
            text=True,
            timeout=self.limit_s,
        )
        self.assertEqual(done.returncode, 1, done.stdout)
        return done.stdout.splitlines()

    def warnings(self, name: str) -> List[str]:
        lines = Path(self.said[name].name).read_text().splitlines()
        return [line for line in lines if "listens on" in line]


if __name__ == "__main__":
    init_node("network_test")
    rostest.rosrun("yarm", "network", NetworkTest)
