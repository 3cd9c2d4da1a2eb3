#!/usr/bin/env python3
"""A person in the way of a robot's tip: how soon it is in the map, how soon the robot stands, and how near it came.

    source tools/env.sh && python3 bench/person.py --seeds 3

For each seed the person of ``scenes/cell/person_crossing.yaml`` crosses the way, walks towards the tip, and appears in
its way and stands; place and moment vary with the seed. Real time, everything running; times are simulated, from the
moment the person is there. The person stops for nothing, so what happens after the robot stands does not count; a robot
that is met while it still moves is carried along, so that its coming to rest after that is not a stop.

Columns of ``bench/data/person.csv``: speed of the tip at the beginning; time to the first map with the person (its
stamp); to the safety monitor's first look that names it as nearest; to the first look that holds the robot; to the
first zero velocity sent to it; until it stands by itself (inf: it was met first); greatest delay of a map on its way
meanwhile; least gap until it stood or was met; time to the first touch (inf: none), and the tip's speed then.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, Dict, List, Tuple

import raw_rows
import rospy
import yaml
from geometry_msgs.msg import Twist
from sim_time import await_simulated_time
from tf2_msgs.msg import TFMessage
from yarm.msg import Clearance, SafetyStatus, SimStatus

from yarm.geometry import CellMap
from yarm.resources import resource
from yarm.ros.common import names
from yarm.ros.common.conversions import MapSubscriber
from yarm.ros.common.start import init_node
from yarm.ros.experiment.launcher import Family

KINDS = ("crossing", "head-on", "standing")
ROBOT, PERSON, UNKNOWN = "ankurbot_1", "person", "unknown"
STILL_MPS = 0.03
READY = "ready"
"""What the watching process says when the cell is there: before, commander_cli would go by the wrong clock."""
WATCH_S = 4.0
"""Simulated time that is looked at after the person has come, s."""
RUN_LIMIT_S = 120.0
COLUMNS = (
    "speed_mps",
    "to_map_s",
    "to_seen_s",
    "to_held_s",
    "to_zero_s",
    "to_stop_s",
    "map_late_s",
    "least_gap_m",
    "to_met_s",
    "met_mps",
    "real_time_factor",
)
Sample = Tuple[float, float, float]

LAUNCH = """<launch>
  <include file="$(find yarm)/launch/cell/full_system.launch">
    <arg name="scene" value="{scene}"/>
    <arg name="seed" value="{seed}"/>
    <arg name="sander" value="false"/>
  </include>
  <param name="simulation/clearance_every" type="int" value="1"/>
</launch>
"""


def scene_of(kind: str, seed: int) -> Dict[str, Any]:
    """The shipped scene with the person's way of this kind, varied by the seed."""
    raw: Dict[str, Any] = yaml.safe_load(resource("scenes", "cell", "person_crossing.yaml").read_text())
    draw = random.Random(f"{kind} {seed}")
    spawn, move = raw["events"]
    below = draw.uniform(1.8, 2.1)
    for event in raw["events"]:
        event["when"]["below"] = below
    person, tip_x = spawn["do"]["spawn"], raw["targets"][0]["x"] + below
    if kind == "crossing":
        person["x"] = tip_x - 0.9 + draw.uniform(-0.2, 0.2)
    elif kind == "head-on":
        person.update(x=tip_x - draw.uniform(1.2, 1.5), y=1.65 + draw.uniform(-0.1, 0.1))
        move["do"].update(dx=1.3, dy=0.0)
    else:
        person.update(x=tip_x - draw.uniform(0.7, 0.9), y=1.65 + draw.uniform(-0.1, 0.1))
        raw["events"] = [spawn]
    return raw


class Watch:
    """What one run hears; times are simulated seconds."""

    def __init__(self, scene: Dict[str, Any]) -> None:
        """Listen; the scene says how near its target the tip is when the person comes."""
        target, when = scene["targets"][0], scene["events"][0]["when"]
        self._trigger = (target["x"], target["y"], when["below"])
        self.came_s = math.inf
        self.mapped_s = math.inf
        self.now_s = 0.0
        self.factor = math.nan
        self.tips: List[Sample] = []
        self.gaps: List[Tuple[float, float]] = []
        self.looks: List[Tuple[float, str, bool]] = []
        self.zeros_s: List[float] = []
        self.late: List[Tuple[float, float]] = []
        self._ee = names.ee_frame(ROBOT)
        self._changed = threading.Condition()
        self._maps = MapSubscriber(self._on_map)
        rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=1000)
        rospy.Subscriber(names.SIM_CLEARANCE, Clearance, self._on_clearance, queue_size=1000)
        rospy.Subscriber(names.SAFETY_STATUS, SafetyStatus, self._on_safety, queue_size=1000)
        rospy.Subscriber(names.cmd_vel(ROBOT), Twist, self._on_command, queue_size=1000)
        rospy.Subscriber(names.SIM_STATUS, SimStatus, self._on_sim, queue_size=10)

    def listen(self) -> None:
        """Until the cell is there; RUN_LIMIT_S at most."""
        deadline = time.monotonic() + RUN_LIMIT_S
        with self._changed:
            while not (self.tips and self._maps.newest()) and time.monotonic() < deadline:
                self._changed.wait(0.5)

    def wait(self) -> None:
        """Until enough time has passed after the person has come; RUN_LIMIT_S at most."""
        deadline = time.monotonic() + RUN_LIMIT_S
        with self._changed:
            while self.now_s < self.came_s + WATCH_S and time.monotonic() < deadline:
                self._changed.wait(0.5)

    def figures(self) -> Dict[str, float]:
        """What the columns say, by their names."""
        came_s, moving = self.came_s, self._moving()
        met_s = next((t for t, gap in self.gaps if t >= came_s and gap <= 0.0), math.inf)
        stood_s = next((t for t, v in moving if t > came_s and v < STILL_MPS), math.inf)
        end_s = min(met_s, stood_s)
        looks = [(t, nearest, held) for t, nearest, held in self.looks if t >= came_s]
        return {
            "speed_mps": max((v for t, v in moving if abs(t - came_s) < 0.1), default=math.nan),
            "to_map_s": self.mapped_s - came_s,
            "to_seen_s": next((t for t, nearest, _ in looks if nearest.startswith(UNKNOWN)), math.inf) - came_s,
            "to_held_s": next((t for t, _, held in looks if held), math.inf) - came_s,
            "to_zero_s": next((t for t in self.zeros_s if t > came_s), math.inf) - came_s,
            "to_stop_s": (stood_s if stood_s < met_s else math.inf) - came_s,
            "map_late_s": max((late for t, late in self.late if came_s <= t <= end_s), default=math.nan),
            "least_gap_m": min((gap for t, gap in self.gaps if came_s <= t <= end_s), default=math.inf),
            "to_met_s": met_s - came_s,
            "met_mps": next((v for t, v in moving if t >= met_s), math.nan),
            "real_time_factor": self.factor,
        }

    def _moving(self) -> List[Tuple[float, float]]:
        """Speed of the tip over 50 ms, at the end of each stretch."""
        found, first = [], 0
        for t, x, y in self.tips:
            while t - self.tips[first][0] > 0.05:
                first += 1
            s, a, b = self.tips[first]
            if t > s:
                found.append((t, math.hypot(x - a, y - b) / (t - s)))
        return found

    def _on_map(self, cell_map: CellMap) -> None:
        self.late.append((cell_map.stamp_s, rospy.get_time() - cell_map.stamp_s))
        if cell_map.stamp_s < self.came_s or self.mapped_s < math.inf:
            return
        if any(name.startswith(UNKNOWN) and len(found.cells) for name, found in cell_map.objects.items()):
            self.mapped_s = cell_map.stamp_s

    def _on_tf(self, message: TFMessage) -> None:
        for transform in message.transforms:
            if transform.child_frame_id.lstrip("/") == self._ee:
                at, stamp_s = transform.transform.translation, transform.header.stamp.to_sec()
                with self._changed:
                    self.tips.append((stamp_s, at.x, at.y))
                    x, y, below = self._trigger
                    if math.hypot(at.x - x, at.y - y) < below:
                        self.came_s = min(self.came_s, stamp_s)
                    self.now_s = stamp_s
                    self._changed.notify()

    def _on_clearance(self, message: Clearance) -> None:
        for robot, nearest, distance in zip(message.robots, message.nearest, message.distances):
            if robot == ROBOT and nearest == PERSON:
                self.gaps.append((message.header.stamp.to_sec(), distance))

    def _on_safety(self, message: SafetyStatus) -> None:
        for robot, nearest, held in zip(message.robots, message.nearest, message.stopped):
            if robot == ROBOT:
                self.looks.append((message.header.stamp.to_sec(), nearest, held))

    def _on_command(self, message: Twist) -> None:
        if message.linear.x == message.angular.z == 0.0:
            self.zeros_s.append(rospy.get_time())

    def _on_sim(self, message: SimStatus) -> None:
        self.factor = message.real_time_factor


def measure(scene: Path) -> None:
    """In a process of its own: watch the run on this ROS master, say when it may begin, print its figures as JSON."""
    await_simulated_time("person_watch", RUN_LIMIT_S)
    init_node("person_watch")
    watch = Watch(yaml.safe_load(scene.read_text()))
    watch.listen()
    print(READY, flush=True)
    watch.wait()
    print(json.dumps(watch.figures()), flush=True)


def run(kind: str, seed: int, port: int) -> Dict[str, Any]:
    """One run with its own ROS master."""
    environment = dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}")
    with tempfile.TemporaryDirectory() as folder:
        scene, launch, log, said = (Path(folder) / name for name in ("person.yaml", "person.launch", "log", "said"))
        scene.write_text(yaml.safe_dump(scene_of(kind, seed)))
        launch.write_text(LAUNCH.format(scene=scene, seed=seed))
        with log.open("w") as output, said.open("w") as words:
            own = {"env": environment, "stderr": subprocess.STDOUT, "start_new_session": True}
            cell = subprocess.Popen(["roslaunch", "-p", str(port), str(launch)], stdout=output, **own)
            commander_cli = str(Path(os.environ["YARM_ROOT"]) / "scripts" / "commander_cli")
            driver = None
            try:
                watcher = subprocess.Popen(
                    [sys.executable, __file__, "--measure", str(scene)],
                    env=environment,
                    stdout=subprocess.PIPE,
                    text=True,
                )
                assert watcher.stdout is not None
                while watcher.stdout.readline() not in (READY + "\n", ""):
                    pass  # rospy itself says there that the master is not up yet
                driver = subprocess.Popen([sys.executable, commander_cli, "run", "--once"], stdout=words, **own)
                found = watcher.communicate(timeout=RUN_LIMIT_S + 60.0)[0].strip().splitlines()
            finally:
                for child in (driver, cell):
                    if child is not None:
                        Family(child).stop()
        last = said.read_text().strip().splitlines()[-1:]
    figures = json.loads(found[-1]) if found else {}
    return {"kind": kind, "seed": seed, **figures, "said": last[0] if last else ""}


def main() -> int:
    """Every kind and seed, a line each, and a CSV."""
    options = argparse.ArgumentParser(description="A person in the way of a robot's tip.")
    options.add_argument("--seeds", type=int, default=3)
    options.add_argument("--kinds", nargs="*", default=list(KINDS), choices=KINDS)
    options.add_argument("--port", type=int, default=12290, help="port of the runs' ROS master")
    options.add_argument("--results", type=Path, default=raw_rows.DATA / "person.csv")
    options.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    arguments = options.parse_args()
    if arguments.measure is not None:
        measure(arguments.measure)
        return 0
    rows: List[Dict[str, Any]] = []
    for kind in arguments.kinds:
        for seed in range(1, arguments.seeds + 1):
            figures = run(kind, seed, arguments.port)
            values = {name: f"{figures.get(name, math.nan):.3f}" for name in COLUMNS}
            rows.append({"kind": kind, "seed": seed, **values})
            raw_rows.save(arguments.results, rows)
            print(f"{kind} seed {seed}: {words_of(figures)}", flush=True)
    return 0


def words_of(figures: Dict[str, Any]) -> str:
    """The figures of a run, or why it does not count."""
    if math.isnan(figures.get("speed_mps", math.nan)):
        return f"does not count: the tip did not come near enough to its target; the Commander: {figures.get('said')}"
    return ", ".join(f"{name} {figures.get(name, math.nan):.3f}" for name in COLUMNS)


if __name__ == "__main__":
    raise SystemExit(main())
