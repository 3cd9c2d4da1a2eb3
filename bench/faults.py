#!/usr/bin/env python3
"""Nodes killed and frozen at the worst moments of a mission in physics: who comes back, who stands, does it end well.

    source tools/env.sh && python3 bench/faults.py --tries 5
    python3 bench/faults.py --nodes commander --faults kill --moments step pause --tries 1
    python3 bench/faults.py --report

Each run is ``run_experiment`` with 1m1ma, ``--cleanup``, in real time (lock-step starts nobody again). In the midst of
the calibration, of a step, of a pause of the sander or of the cleanup, after a while drawn from the seed, one node gets
SIGKILL, or SIGSTOP and 5 s of wall time later SIGCONT, or stalls: ten times SIGSTOP, after 0.05 to 0.8 s SIGCONT, and
as long until the next, all drawn from the seed. A row a run goes to a CSV file, and one that is there is not run
again; a run in which nothing was done to anybody, because the cell did not come up, leaves none. Columns: simulated
time of the fault; wall and simulated time from there to the first message of the node's main topic that is stamped
0.2 s later or more (of a node that was frozen this includes the 5 s; inf: none came; of a simulation that was killed
the new cell's time; of run_experiment, which sends nothing, until it answers the master's question; of the ROS master,
under keep_running, wall time until the next one knows a Commander); how far the robots' tips went,
and how far any joint of the arm turned, from 1 s of simulated time after the fault until then; failure contacts
by ground truth, whether every goal was reached and the way home made, and what the run says was wrong.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import signal
import subprocess
import sys
import threading
import time
import xmlrpc.client
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import raw_rows
import rospy
import yaml
from actionlib_msgs.msg import GoalStatusArray
from faults_page import FAULTS, MOMENTS, NODES, Key, key_of, known_rows, page, written
from sensor_msgs.msg import JointState
from sim_time import await_simulated_time
from tf2_msgs.msg import TFMessage
from yarm.msg import (
    CommanderStatus,
    Contacts,
    MapMetaData,
    SafetyStatus,
    SanderStatus,
    SimStatus,
    TransformStampedVector,
)

from yarm.commander.events import TaskState
from yarm.control.sander.states import SanderState
from yarm.geometry.kinds import ContactKind
from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.ros.experiment.launcher import Family

CASE, ROBOT, ARM = "1m1ma", "ankurbot_1", "hc10_barc"
OUTPUTS: Dict[str, Tuple[str, Any]] = {
    "perception": (names.PLANNING_METADATA, MapMetaData),
    "seed_tf_publisher": (names.SEED_TRANSFORMS, TransformStampedVector),
    "commander": (names.COMMANDER_STATUS, CommanderStatus),
    "multi_robot_controls_server": (f"{names.move_robot(ROBOT)}/status", GoalStatusArray),
    "hc10_state_machine": (names.sander_status(ARM), SanderStatus),
    "safety_monitor": (names.SAFETY_STATUS, SafetyStatus),
    "simulation": (names.SIM_CONTACTS, Contacts),
}
"""Main topic of each node that has one."""
MASTER = "roscore"
ANEW_S = 1.0
"""What is stamped so long before the fault is of a cell that has begun anew, s."""
FROZEN_S = 5.0
"""Wall time that a node is frozen, s."""
STALLS, STALL_S = 10, (0.05, 0.8)
"""How often a node stalls, and for how long, wall time, s."""
FRESH_S, BRAKED_S = 0.2, 1.0
"""Simulated time after the fault from which a message is a new one, and from which nothing may move, s."""
WAIT_S, DELAY_S = 900.0, 2.0
"""Wall time in which the moment must come, and greatest simulated time from its beginning to the fault, s."""
COLUMNS = (
    "fault_at_s",
    "back_wall_s",
    "back_s",
    "tip_moved_m",
    "arm_turned_rad",
    "contacts",
    "success",
    "said",
)


class Injector:
    """Waits for a moment, does the fault, and watches what follows; times are simulated seconds unless said."""

    def __init__(self, node: str, moment: str) -> None:
        """Listen."""
        self._moment = moment
        self._changed = threading.Condition()
        self._commander, self._sander = CommanderStatus(), SanderStatus()
        self._tips: Dict[str, List[Tuple[float, float, float]]] = {}
        self._joints: List[Tuple[float, Tuple[float, ...]]] = []
        self._fault: Optional[Tuple[float, float]] = None
        self._node, self._touched = node, 0
        self.back: Optional[Tuple[float, float]] = None
        rospy.Subscriber(names.SIM_STATUS, SimStatus, self._on_sim, queue_size=10)
        rospy.Subscriber(names.COMMANDER_STATUS, CommanderStatus, self._keep("_commander"), queue_size=100)
        rospy.Subscriber(names.sander_status(ARM), SanderStatus, self._keep("_sander"), queue_size=100)
        rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=1000)
        rospy.Subscriber(names.joint_states(ARM), JointState, self._on_joints, queue_size=1000)
        if node in OUTPUTS:
            topic, kind = OUTPUTS[node]
            rospy.Subscriber(topic, kind, self._on_output, queue_size=1000)

    def now_there(self) -> bool:
        """Whether the moment is there."""
        status = self._commander
        if self._moment == "calibration":
            return bool(status.state == CommanderStatus.CALIBRATION and status.busy)
        if self._moment == "cleanup":
            return bool(status.state == CommanderStatus.CLEANUP and status.busy)
        if not (status.state == CommanderStatus.BOUNDLESS and status.busy):
            return False
        if self._moment == "pause":
            return bool(self._sander.state == SanderState.SCAN_TO_PATH and not self._sander.enabled)
        return any(task.status == TaskState.MOVING.value for task in status.tasks)

    def wait(self, ready: Callable[[], bool], limit_s: float) -> bool:
        """Until something is so, at most so long by the wall; whether it is."""
        deadline = time.monotonic() + limit_s
        with self._changed:
            while not ready() and time.monotonic() < deadline and not rospy.is_shutdown():
                self._changed.wait(0.2)
            return ready()

    def strike(self, pid: int, fault: str, draw: random.Random) -> None:
        """Do the fault; returns when the node could run again."""
        with self._changed:
            self._fault = (rospy.get_time(), time.monotonic())
        if fault == "kill":
            os.kill(pid, signal.SIGKILL)
            return
        for frozen_s in [FROZEN_S] if fault == "stop" else [draw.uniform(*STALL_S) for _ in range(STALLS)]:
            os.kill(pid, signal.SIGSTOP)
            time.sleep(frozen_s)
            os.kill(pid, signal.SIGCONT)
            if fault == "stall":
                time.sleep(draw.uniform(*STALL_S))

    def figures(self) -> Dict[str, Any]:
        """What the columns say, as far as this process knows."""
        assert self._fault is not None
        at_s, wall_s = self._fault
        back_s, back_wall_s = self.back or (math.inf, math.inf)
        anew = back_s < at_s
        tip = max((_way(self._between(track, at_s, back_s)) for track in self._tips.values()), default=0.0)
        turned = [joints for _, joints in self._between(self._joints, at_s, back_s)]
        arm = max((max(abs(a - b) for a, b in zip(turned[0], other)) for other in turned), default=0.0)
        return {
            "fault_at_s": at_s,
            "back_wall_s": back_wall_s - wall_s,
            "back_s": back_s if anew else back_s - at_s,
            "tip_moved_m": tip,
            "arm_turned_rad": arm,
            "touched": self._touched,
        }

    def pid(self) -> int:
        """Process of the node; raises when it, or the master, does not answer."""
        master = rospy.get_master()
        if self._node == MASTER:
            return int(master.getPid()[2])
        uri = master.lookupNode("/" + self._node)[2]
        return int(xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())[2])

    def await_answer(self, killed: int, limit_s: float) -> None:
        """Until who sends nothing answers again: another process than the one that was killed, if one was (0: none)."""
        deadline = time.monotonic() + limit_s
        while time.monotonic() < deadline:
            try:
                known = self._node != MASTER or rospy.get_master().lookupNode("/commander")[0] == 1
                if known and self.pid() != killed:
                    self.back = (math.nan if self._node == MASTER and killed else rospy.get_time(), time.monotonic())
                    return
            except (OSError, TypeError, ValueError, xmlrpc.client.Error):  # it does not answer, or is not known
                pass
            time.sleep(0.1)

    @staticmethod
    def _between(samples: Sequence[Any], at_s: float, back_s: float) -> List[Any]:
        return [sample for sample in samples if at_s + BRAKED_S < sample[0] < back_s]

    def _keep(self, name: str) -> Callable[[Any], None]:
        def keep(message: Any) -> None:
            with self._changed:
                setattr(self, name, message)
                self._changed.notify_all()

        return keep

    def _on_tf(self, message: TFMessage) -> None:
        for transform in message.transforms:
            if transform.child_frame_id.lstrip("/") == names.ee_frame(ROBOT):
                at = transform.transform.translation
                with self._changed:
                    self._tips.setdefault(ROBOT, []).append((transform.header.stamp.to_sec(), at.x, at.y))

    def _on_sim(self, message: SimStatus) -> None:
        self._touched = len(message.touched)

    def _on_joints(self, message: JointState) -> None:
        with self._changed:
            self._joints.append((message.header.stamp.to_sec(), tuple(message.position)))

    def _on_output(self, message: Any) -> None:
        with self._changed:
            stamp_s, at_s = message.header.stamp.to_sec(), self._fault[0] if self._fault else math.nan
            fresh = stamp_s > at_s + FRESH_S or stamp_s < at_s - ANEW_S
            if fresh and self.back is None:
                self.back = (rospy.get_time(), time.monotonic())
            self._changed.notify_all()


def _way(track: Sequence[Tuple[float, float, float]]) -> float:
    """Greatest distance from the first place of a track, metres."""
    return max((math.hypot(x - track[0][1], y - track[0][2]) for _, x, y in track), default=0.0)


def inject(node: str, fault: str, moment: str, seed: int) -> None:
    """In a process of its own, on this ROS master: one fault; its figures as JSON."""
    await_simulated_time("faults", WAIT_S)
    init_node("faults")
    injector, draw = Injector(node, moment), random.Random(f"{node} {fault} {moment} {seed}")
    if not injector.wait(injector.now_there, WAIT_S):
        print(json.dumps({"said": f"the moment, {moment}, did not come"}), flush=True)
        return
    until_s = rospy.get_time() + draw.uniform(0.0, DELAY_S)
    injector.wait(lambda: rospy.get_time() >= until_s or not injector.now_there(), WAIT_S)
    pid = injector.pid()
    injector.strike(pid, fault, draw)
    print(json.dumps(injector.figures()), flush=True)
    if node in OUTPUTS:
        injector.wait(lambda: injector.back is not None, WAIT_S)
    else:
        injector.await_answer(pid if fault == "kill" else 0, WAIT_S)
    print(json.dumps(injector.figures()), flush=True)


def run(key: Key, port: int, results: Path) -> Dict[str, Any]:
    """One run with its own ROS master."""
    folder, seed = (results / "-".join(map(str, key))).resolve(), key[-1]
    environment = dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}")
    script = str(Path(os.environ["YARM_ROOT"]) / "scripts" / "run_experiment")
    options = [
        "--case",
        CASE,
        "--removal",
        "delete",
        "--seed",
        str(seed),
        "--nominal",
        "--cleanup",
        "--port",
        str(port),
    ]
    options += ["--results", str(folder), "--wall-limit", str(WAIT_S)]
    call = [sys.executable, script, *options]
    if key[0] == MASTER:
        keep = str(Path(os.environ["YARM_ROOT"]) / "scripts" / "keep_running")
        asked = {"case": CASE, "removal": "delete", "seed": seed, "vary": "false", "cleanup": "true", "results": folder}
        call = [sys.executable, keep, "experiment.launch", *(f"{name}:={value}" for name, value in asked.items())]
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "console.txt").open("w") as log:
        mission = subprocess.Popen(call, stdout=log, stderr=subprocess.STDOUT, env=environment)
        injector = subprocess.Popen(
            [sys.executable, __file__, "--inject", *map(str, key)], env=environment, stdout=subprocess.PIPE, text=True
        )
        try:
            mission.wait(timeout=2.0 * WAIT_S)
            said = injector.communicate(timeout=60.0)[0].strip().splitlines()
        except subprocess.TimeoutExpired:  # it waits for a node that never came back, or for a fault that never was
            injector.kill()
            said = injector.communicate()[0].strip().splitlines()
        finally:
            for child in (injector, mission):
                Family(child).stop()
    figures = json.loads(said[-1]) if said and said[-1].startswith("{") else {"said": "no word of the injector"}
    found = outcome(folder / CASE / str(seed) / "summary.yaml", figures.get("said", ""))
    if key[0] == MASTER and found["contacts"] != "":  # these are of the second start
        found["contacts"] += figures.get("touched", 0)
    return {**figures, **found}


def outcome(summary: Path, said: str) -> Dict[str, Any]:
    """What the mission came to by its own results."""
    if not summary.is_file():
        return {"contacts": "", "success": False, "said": said or "no results were written"}
    values: Mapping[str, Any] = yaml.safe_load(summary.read_text())
    contacts = sum(contact["kind"] == ContactKind.FAILURE for contact in values["contacts"])
    faults = "; ".join(filter(None, [said, *values["faults"]]))
    return {"contacts": contacts, "success": bool(values["success"]), "said": faults}


def main() -> int:
    """Run what is missing, print the table; 0 when every mission of it ended well without a contact."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", nargs="+", choices=NODES, default=list(NODES))
    parser.add_argument("--faults", nargs="+", choices=FAULTS, default=list(FAULTS))
    parser.add_argument("--moments", nargs="+", choices=MOMENTS, default=list(MOMENTS))
    parser.add_argument("--tries", type=int, default=5, help="seeds 1 to this many")
    parser.add_argument("--port", type=int, default=12390, help="port of the runs' ROS master")
    parser.add_argument("--results", type=Path, default=Path("results") / "faults", help="folder of the runs")
    parser.add_argument("--csv", type=Path, default=raw_rows.DATA / "faults.csv")
    parser.add_argument("--report", action="store_true", help="only the table of what was run, and its page")
    parser.add_argument("--page", type=Path, default=raw_rows.DATA.parent / "faults.md")
    parser.add_argument("--inject", nargs=4, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.inject:
        inject(*options.inject[:3], int(options.inject[3]))
        return 0
    rows = known_rows(options.csv)
    wanted = [
        (node, fault, moment, seed)
        for seed in range(1, options.tries + 1)
        for moment in options.moments
        for fault in options.faults
        for node in options.nodes
    ]
    undone = 0
    for key in [] if options.report else [key for key in wanted if key not in map(key_of, rows)]:
        found = run(key, options.port, options.results)
        if "fault_at_s" not in found:  # nothing happened to anybody: no row, so that it is run again
            print(" ".join(map(str, key)) + f": no fault was done: {found['said']}", flush=True)
            undone += 1
            continue
        values = {name: found.get(name, math.nan) for name in COLUMNS}
        shown = {n: f"{v:.3f}" if isinstance(v, float) else v for n, v in values.items()}
        rows.append({**dict(zip(("node", "fault", "moment", "seed"), key)), **shown})
        raw_rows.save(options.csv, rows)
        print(" ".join(map(str, key)) + f": {shown}", flush=True)
    options.page.write_text(written(rows), encoding="utf-8")
    print(page(rows))
    well = all(str(r["success"]) == "True" and str(r["contacts"]) == "0" for r in rows)
    return 0 if well and undone == 0 else 1


if __name__ == "__main__":
    raise SystemExit(main())
