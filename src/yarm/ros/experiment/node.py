"""Node ``run_experiment``: one experiment against a running system, from switching on to the results on disk."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import FrozenSet, Optional

import rospy

from yarm.commander.params import Removal
from yarm.console.results import FILM
from yarm.experiments.run.cases import Case, case_of, expected_goals, layout_of
from yarm.experiments.run.ledger import LedgerError
from yarm.experiments.run.record import RunInfo, RunRecord
from yarm.experiments.run.recorder import GAP_S, Recorder
from yarm.experiments.run.soak import MissionRow, judge_soak, soak_line
from yarm.experiments.run.squares import parts_of
from yarm.experiments.run.tables import summary_table
from yarm.experiments.run.writers import write_rows
from yarm.geometry import GridSpec
from yarm.ros.commander.reports import task_text
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node
from yarm.ros.console.filmer import filmer_of
from yarm.ros.experiment.console import say
from yarm.ros.experiment.inputs import ExperimentInputs
from yarm.ros.experiment.lock_step import LockStep
from yarm.ros.experiment.mission import POLL_S, BegunAgainError, MissionDriver, MissionError
from yarm.ros.experiment.params import ExperimentParams
from yarm.ros.experiment.replay import Replay
from yarm.ros.experiment.results import parameters, versions, write_results
from yarm.ros.experiment.saved import Began, SavedRun, Saver
from yarm.ros.experiment.soak import Soak
from yarm.ros.experiment.usage import UsageMeter
from yarm.sim.scenes.scene import Scene, SceneError, load_scene

PROGRESS_S = 1.0
RASTER_LIMIT_S = 300.0
CATCH_UP_S = 10.0
"""Wall time that poses which are under way are waited for, s."""


class Experiment:
    """Runs one experiment and keeps its record."""

    def __init__(self, params: ExperimentParams) -> None:
        """Listen; nothing is driven yet."""
        self._params = params
        self._case: Case = case_of("soak" if params.soak_s > 0.0 else Path(params.case).stem)
        folder = Path(params.results) / self._case.name / str(params.seed)
        self._saver = Saver(folder)
        self._found = self._saver.found()
        fresh = Recorder(GridSpec(), [], 0.0, params.path_period_s)
        if self._found is not None:
            self._found.recorder.resume()
        self._inputs = ExperimentInputs(self._found.recorder if self._found else fresh)
        before = self._saver.film() if self._found else None
        self._filmer = filmer_of(f"{self._case.name}/{params.seed}", params.film_hz, before)
        self._lock_step = LockStep() if params.sync else None
        self._driver = MissionDriver(self._inputs, params, self._progress, self._lock_step)
        self._replay = Replay(params, self._inputs) if params.replay else None
        self._meter = UsageMeter()
        self._soak: Optional[Soak] = None
        self._scene: Optional[Scene] = None
        if params.soak_s > 0.0:
            self._soak = Soak(self._inputs, self._driver, self._meter, params.seed, say)
        self._said_wall = 0.0
        self._said_sim_s = 0.0
        self._began: Optional[Began] = None
        self._record: Optional[RunRecord] = None
        self._failure = ""

    def run(self) -> RunRecord:
        """Drive the whole experiment; whatever goes wrong ends up in the record."""
        self._saver.begin(self._packed, self._inputs.lock, self._filmer.film if self._filmer else None)
        found = self._found
        while True:
            try:
                record = self._mission(found)
            except BegunAgainError as error:
                say(f"{error}; the mission begins anew")
                found, self._began, self._record, self._failure = None, None, None, ""
                continue
            if self._replay is None:
                self._driver.release()
            return record

    def _mission(self, found: Optional[SavedRun]) -> RunRecord:
        """One mission from the cell's beginning, or from where a process before has died.

        Raises:
            BegunAgainError: there is another beginning.
        """
        try:
            self._scene = load_scene(self._params.case, self._params.seed if self._params.vary else -1)
            own = not self._params.vary or self._params.seed in (-1, self._scene.seed)
            self._case = self._case.for_layout(own, Removal(self._params.removal), self._params.sand_elsewhere)
            if found is not None:
                self._take_up(found)
            if self._began is None:
                with self._inputs.lock:
                    self._inputs.recorder.follow_parts(parts_of(self._scene))
                self._start()
            if self._record is None:
                self._drive(expected_goals(self._scene))
        except BegunAgainError:
            if self._soak is None and self._replay is None:
                raise
            self._failure = "the simulation was started again: a soak, or a replay, cannot go on"
        except (MissionError, SceneError, rospy.ServiceException) as error:
            self._failure = str(error)
        self._record = record = self._record or self._finish(self._failure)
        if self._replay is None and self._params.cleanup and not self._failure:
            self._saver.keep()
            record = self._clean_up(record)
        return record

    def _take_up(self, found: SavedRun) -> None:
        """Go on where the process before has died.

        Raises:
            MissionError: the cell is not there.
        """
        self._inputs.take_up(found.ended_s, found.declared, found.begun_again)
        self._driver.await_start()
        now_s = self._driver.now_s()
        if now_s < found.now_s:
            self._inputs.forget()
            return
        missed_s = now_s - found.now_s
        self._began, self._record, self._failure = found.began, found.record, found.failure
        self._inputs.look_at_arms()
        words = f"taken up at {now_s:.1f} s: this process had died; {missed_s:.1f} s are not recorded"
        say(words)
        if self._filmer is not None:
            self._filmer.film.note(words)

    def _start(self) -> None:
        """From switching on until the mode is entered, and the mission begins.

        Raises:
            MissionError: it cannot go on.
        """
        self._driver.await_start()
        at_work = self._driver.switch_on_and_calibrate()
        if not at_work:
            self._driver.await_raster(self._params.raster, RASTER_LIMIT_S)
        self._begin()
        if not at_work:
            self._driver.enter_mode()

    def _drive(self, expected: FrozenSet[str]) -> None:
        """In the mode until the last goal has ended.

        Raises:
            MissionError: it cannot go on.
        """
        if self._soak is not None:
            self._soak.run(self._params.soak_s)
        else:
            self._driver.run_mode(expected, self._params.limit_s or self._case.limit_s)
            self._catch_up()

    def _catch_up(self) -> None:
        """A process that has stood still hears words before poses: those until now are waited for, but not for ever.

        So is, where something was missed, who has touched whom until now: ``sim/status``, once a second.
        """
        until, now_s = time.monotonic() + CATCH_UP_S, self._driver.now_s()
        while self._lock_step is None and time.monotonic() < until:
            with self._inputs.lock:
                recorder, sim = self._inputs.recorder, self._inputs.state.sim
                told = sim is not None and sim.header.stamp.to_sec() >= now_s
                if recorder.heard_s > now_s - GAP_S and (told or recorder.missed_s == 0.0):
                    return
            time.sleep(POLL_S)

    def replay(self) -> int:
        """Drive up to the decision and say what came of it; exit code 0 only when the cell stands at the same one."""
        assert self._replay is not None
        record = self.run()
        stood = self._lock_step is not None and self._lock_step.stopped
        faults = () if stood else record.faults
        return self._replay.end(faults, Path(self._params.results) / self._case.name / str(self._params.seed))

    def write(self, record: RunRecord) -> Path:
        """Write the results; the folder they are in."""
        folder = Path(self._params.results) / self._case.name / str(self._params.seed)
        folder.mkdir(parents=True, exist_ok=True)
        if self._filmer is not None:
            self._filmer.end().write(folder / FILM)
        if self._soak is not None:
            write_rows(folder / "missions.csv", MissionRow, self._soak.rows)
            say(soak_line(self._soak.rows))
        write_results(record, folder, self._params.plots)
        self._saver.end()
        return folder.resolve()

    def _begin(self) -> None:
        """The mission starts now: what is measured counts from here."""
        self._meter.start()
        now_s = self._driver.now_s()
        if self._replay is not None and self._lock_step is not None:
            self._lock_step.stop_at(now_s + self._replay.stop_after_s)
        began = (now_s, time.monotonic(), self._inputs.camera_sets())
        with self._inputs.lock:
            self._began = began
            self._inputs.recorder.begin(now_s)
            self._inputs.loop_ms.clear()

    def _packed(self) -> SavedRun:
        """What this knows; the inputs' lock must be held."""
        recorder, ended_s, declared, begun_again, now_s = self._inputs.saved()
        return SavedRun(recorder, ended_s, declared, begun_again, self._began, now_s, self._record, self._failure)

    def _finish(self, failure: str) -> RunRecord:
        began = self._began or (self._driver.now_s(), time.monotonic(), self._inputs.camera_sets())
        sim_s = self._driver.now_s() - began[0]
        wall_s = time.monotonic() - began[1]
        sets = self._inputs.camera_sets() - began[2]
        outcome, reason = self._driver.outcome()
        info = RunInfo(
            self._case.name,
            self._params.seed,
            self._params.mode,
            "failed" if failure else outcome,
            failure or reason,
            sim_s,
            wall_s,
            sim_s / wall_s if wall_s > 0 else float("nan"),
            sets,
            self._inputs.mean_loop_ms(),
            versions(),
            parameters(),
            {} if self._scene is None else layout_of(self._scene),
            self._params.removal,
            self._inputs.begun_again,
            self._inputs.recorder.missed_s,
        )
        lost = self._meter.lost()
        usage = self._meter.finish(sets)
        with self._inputs.lock:
            record = self._inputs.recorder.finish(info, self._case, self._params.arrival_limit_m, usage)
        if self._soak is not None:
            faults = judge_soak(record.usage, lost, self._soak.rows, self._params.memory_limit_mb)
            record = replace(record, success=record.success and not faults, faults=(*record.faults, *faults))
        return record

    def _clean_up(self, record: RunRecord) -> RunRecord:
        try:
            self._driver.clean_up()
        except BegunAgainError:
            raise
        except MissionError as error:
            return replace(record, success=False, faults=(*record.faults, f"cleanup: {error}"))
        return record

    def _progress(self, what: str) -> None:
        """At most one line a second of wall time."""
        if self._replay is not None:
            self._replay.look()
        now = time.monotonic()
        if now - self._said_wall < PROGRESS_S:
            return
        with self._inputs.lock:
            state = self._inputs.state
            rate = (state.now_s - self._said_sim_s) / (now - self._said_wall) if self._said_wall else 0.0
            parts = [f"{state.now_s:7.1f} s", f"x{rate:.2f}"]
            if state.status is not None:
                parts.append(state.status.state_name + (" busy" if state.status.busy else ""))
            parts.append(what)
            parts += [f"{name}: {arm.text()}" for name, arm in sorted(state.manipulators.items())]
            if state.status is not None:
                parts += [task_text(task) for task in state.status.tasks]
            parts.append(f"waypoints: {self._inputs.recorder.waypoints_sent}")
            parts.append(f"touches: {self._inputs.recorder.failures}")
            self._said_sim_s = state.now_s
        self._said_wall = now
        say(" | ".join(parts))


def main() -> int:
    """Run the node; exit code 0 only on success."""
    init_node("run_experiment")
    params = load_params(ExperimentParams)
    try:
        experiment = Experiment(params)
    except LedgerError as error:
        rospy.logfatal("%s", error)
        return 1
    if params.replay:
        return experiment.replay()
    record = experiment.run()
    folder = experiment.write(record)
    say("\n" + summary_table(record) + f"\n\nresults and pictures: {folder}")
    return 0 if record.success else 1
