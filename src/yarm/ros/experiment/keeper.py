"""Node ``mission_keeper``: every mission of a running cell leaves its results and its proof sheet, whoever drives it.

Beside ``run_experiment``, which keeps its own, it is not started.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Optional, Tuple

import rospy

from yarm.experiments.run.cases import Case, layout_of
from yarm.experiments.run.record import RunInfo
from yarm.experiments.run.recorder import Recorder
from yarm.experiments.run.squares import parts_of
from yarm.geometry import GridSpec
from yarm.msg import CommanderStatus
from yarm.params import ParamError
from yarm.ros.common import names
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node
from yarm.ros.experiment.inputs import ExperimentInputs
from yarm.ros.experiment.params import ExperimentParams, KeeperParams
from yarm.ros.experiment.results import parameters, versions, write_results
from yarm.sim.scenes.scene import Scene, SceneError, load_scene

BY_HAND = "by_hand"
"""Folder of results, below which each scene has one, with a folder for each mission."""
STAMP = "%Y-%m-%d_%H.%M.%S"
KEPT = (CommanderStatus.BOUNDED, CommanderStatus.BOUNDLESS, CommanderStatus.CLEANUP)
"""States whose work belongs to a mission."""
POLL_S = 0.2
"""Wall time between two looks whether a mission has ended, s."""


@dataclass(frozen=True)
class Begun:
    """A mission's beginning: simulated time, s, a clock on the wall, s, camera sets until then, its results' folder."""

    sim_s: float
    wall_s: float
    sets: int
    folder: Path


class Keeper:
    """Records a mission from its first decision to the end of its work, and writes what came of it."""

    def __init__(self, params: KeeperParams) -> None:
        """Listen.

        Raises:
            SceneError: the scene cannot be read.
        """
        self._params = params
        self._scene: Scene = load_scene(params.scene, params.seed if params.vary else -1)
        self._case = Case(self._scene.name, f"scene {self._scene.name}, driven by hand")
        self._begun: Optional[Begun] = None
        self._at_work = False
        recorder = Recorder(GridSpec(), [], 0.0, ExperimentParams.path_period_s)
        recorder.follow_parts(parts_of(self._scene))
        self._inputs = ExperimentInputs(recorder, self._begin)

    def run(self) -> None:
        """Until the node is shut down: write a mission when its work has ended, again when it was taken up again."""
        while not rospy.is_shutdown():
            time.sleep(POLL_S)
            ended = self._ended()
            if ended is not None:
                rospy.loginfo("the mission is kept: %s", self._keep(*ended) / "proof.html")

    def _begin(self, now_s: float) -> None:
        sim = self._inputs.state.sim
        self._inputs.recorder.begin(now_s)
        self._inputs.loop_ms.clear()
        folder = Path(self._params.results) / BY_HAND / self._case.name / time.strftime(STAMP)
        self._begun = Begun(now_s, time.monotonic(), 0 if sim is None else int(sim.camera_sets), folder)
        self._at_work = True

    def _ended(self) -> Optional[Tuple[Begun, CommanderStatus]]:
        """A mission whose work is over, and the Commander's word of it; None while it goes on or has been kept."""
        with self._inputs.lock:
            status, begun = self._inputs.state.status, self._begun
            if begun is None or status is None or status.header.stamp.to_sec() <= begun.sim_s:
                return None
            self._at_work |= status.busy and status.state in KEPT
            if not self._at_work or status.busy or not status.outcome:
                return None
            self._at_work = False
            return begun, status

    def _keep(self, begun: Begun, status: CommanderStatus) -> Path:
        sim_s, wall_s = status.header.stamp.to_sec() - begun.sim_s, time.monotonic() - begun.wall_s
        info = RunInfo(
            self._case.name,
            self._scene.seed if self._params.seed < 0 else self._params.seed,
            self._mode(),
            status.outcome,
            status.reason,
            sim_s,
            wall_s,
            sim_s / wall_s,
            self._inputs.camera_sets() - begun.sets,
            self._inputs.mean_loop_ms(),
            versions(),
            parameters(),
            layout_of(self._scene),
            self._params.removal,
        )
        with self._inputs.lock:
            record = self._inputs.recorder.finish(info, self._case, self._params.arrival_limit_m)
        write_results(record, begun.folder, self._params.plots)
        return begun.folder.resolve()

    def _mode(self) -> str:
        """The first decision of a mission is the entry into its mode."""
        with self._inputs.lock:
            return self._inputs.recorder.decisions[0].text.lower()


def main() -> int:
    """Run the node until it is shut down; its exit code."""
    init_node(names.KEEPER_NODE)
    try:
        keeper = Keeper(load_params(KeeperParams))
    except (ParamError, SceneError) as error:
        rospy.logfatal("%s", error)
        return 1
    keeper.run()
    return 0
