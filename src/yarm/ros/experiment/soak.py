"""Runs a soak against a running system: missions one after the other with debris at random."""

from __future__ import annotations

import math
import time
from typing import Callable, Dict, List, Set

import numpy as np
import rospy
from sensor_msgs.msg import Joy

from yarm.control.sander.states import Button, SanderState
from yarm.experiments.run.scoring import refused
from yarm.experiments.run.soak import DROP_Z_M, Drop, MissionRow, drops
from yarm.geometry.kinds import ObjectKind
from yarm.ros.common import names
from yarm.ros.experiment.inputs import ENDED, ExperimentInputs
from yarm.ros.experiment.mission import MissionDriver, MissionError
from yarm.ros.experiment.usage import UsageMeter
from yarm.srv import SpawnObstacles, SpawnObstaclesRequest

MISSION_LIMIT_S = 240.0
SPAWN_TRIES = 5
SPAWN_RETRY_S = 1.0


class Soak:
    """Drops debris, waits until each is reached or refused, and again."""

    def __init__(
        self, inputs: ExperimentInputs, driver: MissionDriver, meter: UsageMeter, seed: int, say: Callable[[str], None]
    ) -> None:
        """Nothing is dropped yet."""
        self._inputs = inputs
        self._driver = driver
        self._meter = meter
        self._say = say
        self._rng = np.random.default_rng(seed)
        self._spawn = rospy.ServiceProxy(names.SPAWN_OBSTACLES, SpawnObstacles)
        self._delete = rospy.ServiceProxy(names.DELETE_OBSTACLES, SpawnObstacles)
        self._joys: Dict[str, rospy.Publisher] = {}
        self.rows: List[MissionRow] = []

    def run(self, span_s: float) -> None:
        """Missions until so much simulated time has passed.

        Raises:
            MissionError: a mission did not end in time, or debris could not be dropped or taken away.
        """
        began_s = self._driver.now_s()
        while self._driver.now_s() - began_s < span_s:
            self._keep_sanding()
            if self._driver.now_s() - began_s > 0.5 * span_s:
                self._meter.half_way()
            self._mission(len(self.rows), began_s)
            self._say(self._line())

    def _mission(self, index: int, began_s: float) -> None:
        start_s = self._driver.now_s()
        planned = drops(index, self._rng)
        dropped: Set[str] = set()
        self._driver.ask_for_more(required=False)
        while not self._over(planned, dropped):
            now_s = self._driver.now_s()
            for drop in planned:
                if drop.name not in dropped and now_s - start_s >= drop.after_s:
                    self._drop(drop)
                    dropped.add(drop.name)
            if now_s - start_s > MISSION_LIMIT_S:
                limit = f"soak mission {index} did not end within {MISSION_LIMIT_S:.0f} s"
                raise MissionError(f"{limit}: {self._driver.who_waits()}")
            self._driver.ask_for_more(required=False)
            self._driver.pause(f"soak mission {index}")
        self._close(index, planned, start_s - began_s, self._driver.now_s() - began_s)

    def _over(self, planned: tuple[Drop, ...], dropped: Set[str]) -> bool:
        with self._inputs.lock:
            goals = {goal.name: goal for goal in self._inputs.recorder.goals}
        ended = {n for n, g in goals.items() if math.isfinite(g.declared_s) or g.status in ENDED}
        return len(dropped) == len(planned) and dropped <= ended and self._driver.idle()

    def _close(self, index: int, planned: tuple[Drop, ...], start_s: float, end_s: float) -> None:
        """Take away what was refused, and write the mission down."""
        with self._inputs.lock:
            own = [g for g in self._inputs.recorder.goals if g.name in {d.name for d in planned}]
            present = set(self._inputs.state.goals)
            failures = self._inputs.recorder.failures
        for goal in own:
            if goal.name in present and refused(goal):
                self._delete(SpawnObstaclesRequest(name=goal.name))
        reached = sum(math.isfinite(g.declared_s) for g in own)
        debris = " ".join(d.name for d in planned)
        memory = self._meter.memory_mb()
        self.rows.append(
            MissionRow(index, start_s, end_s, debris, reached, sum(refused(g) for g in own), failures, memory)
        )

    def _drop(self, drop: Drop) -> None:
        """Drop it; where something is in the way, wait a little."""
        answer = None
        for _ in range(SPAWN_TRIES):
            answer = self._spawn(
                SpawnObstaclesRequest(
                    name=drop.name, type=str(ObjectKind.DEBRIS), x=drop.x_m, y=drop.y_m, z=DROP_Z_M, yaw=drop.yaw_rad
                )
            )
            if answer.success:
                return
            drop = Drop(drop.name, drop.x_m, float(self._rng.uniform(-0.2, 0.2)), drop.yaw_rad, drop.after_s)
            end_s = self._driver.now_s() + SPAWN_RETRY_S
            while self._driver.now_s() < end_s:
                self._driver.pause(f"room to drop {drop.name}")
        raise MissionError(f"{drop.name} could not be dropped: {answer.message if answer else 'no answer'}")

    def _keep_sanding(self) -> None:
        """Start the raster again where it is done."""
        with self._inputs.lock:
            done = [
                n
                for n, arm in self._inputs.state.manipulators.items()
                if arm.state == SanderState.SCAN_TO_PATH and arm.progress >= 1.0
            ]
        for arm in done:
            if arm not in self._joys:
                self._joys[arm] = rospy.Publisher(names.sander_joy(arm), Joy, queue_size=1, latch=False)
                time.sleep(0.5)
            buttons = [0, 0, 0, 0]
            buttons[Button.START] = 1
            self._joys[arm].publish(Joy(buttons=buttons, axes=[0.0] * 4))

    def _line(self) -> str:
        row = self.rows[-1]
        return (
            f"mission {row.index}: {row.end_s - row.start_s:.1f} s, {row.reached} reached, {row.refused} refused, "
            f"{row.failures} failure contacts, {row.memory_mb:.0f} MB"
        )
