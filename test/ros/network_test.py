#!/usr/bin/env python3
"""Who can be reached from other machines: the node itself says it, network_check finds it, and passes the others."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Dict, List

import rostest

from yarm.ros.common.graph import node_pids
from yarm.ros.common.start import init_node
from yarm.safety.listening import listeners

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
ADDRESSES = {"inside": "localhost", "outside": "0.0.0.0"}


class NetworkTest(ListeningTest):
    """Two nodes alike, of which one listens on every interface."""

    @classmethod
    def setUpClass(cls):
        cls.listen()
        cls.said = {name: tempfile.NamedTemporaryFile() for name in ADDRESSES}  # noqa: SIM115 (closed with the class)
        cls.nodes = [cls.begin(name, address) for name, address in ADDRESSES.items()]

    @classmethod
    def tearDownClass(cls):
        for node in cls.nodes:
            node.terminate()
        for node in cls.nodes:
            node.wait(cls.limit_s)
        for file in cls.said.values():
            file.close()

    @classmethod
    def begin(cls, name: str, address: str) -> subprocess.Popen:
        return subprocess.Popen(
            [sys.executable, str(SCRIPTS / "velocity_gate"), f"__name:={name}"],
            stdout=cls.said[name],
            stderr=subprocess.STDOUT,
            env={**os.environ, "ROS_HOSTNAME": address},
        )

    def test_1_the_check_names_who_can_be_reached_and_where(self):
        pids = self.ask(self.both, "the processes of both nodes")
        said = self.check()
        lines = [line for line in said if line.startswith("/outside")]
        self.assertEqual(len(lines), 1, said)
        for listener in listeners(pids["/outside"]):
            self.assertIn(f"0.0.0.0:{listener.port}", lines[0])
        self.assertFalse([line for line in said if line.startswith(("/inside", "/master"))], said)

    def test_2_the_node_says_it_itself(self):
        said = self.ask(lambda: self.warnings("outside"), "a warning of the node that can be reached")
        self.assertIn("ROS_HOSTNAME=localhost", said[0])
        self.assertEqual(self.warnings("inside"), [])

    def both(self) -> Dict[str, int]:
        pids = node_pids()
        return pids if {"/inside", "/outside"} <= set(pids) else {}

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
