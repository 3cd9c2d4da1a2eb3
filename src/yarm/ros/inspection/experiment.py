"""The inspector with a judge beside it: follows one round to its end, keeps its record, writes the results.

It is the node ``inspector`` itself, so that every image it looked at and every order of the round are in the record.
"""

from __future__ import annotations

import math
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Tuple

import rospy
from nav_msgs.msg import Odometry as OdometryMessage

from yarm.console.results import FILM
from yarm.experiments.inspect.eyes import boxes_of
from yarm.experiments.inspect.measures import Measures, faults_of, measure
from yarm.experiments.inspect.record import LookRecord, RoundInfo, RoundRecord, RoundRecorder, TouchRow
from yarm.experiments.inspect.writers import write_inspection
from yarm.experiments.run.tables import markdown_table
from yarm.geometry import Pose2
from yarm.inspection.model import ENDS, PRINTED, Stage, Verdict, reading_words
from yarm.inspection.senses import Senses
from yarm.inspection.session import SessionStep
from yarm.msg import Contacts
from yarm.params import ParamError, build
from yarm.resources import resource
from yarm.robots import turtlebot
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.start import init_node
from yarm.ros.console.filmer import Filmer, filmer_of
from yarm.ros.experiment.console import say
from yarm.ros.experiment.results import parameters, versions
from yarm.ros.inspection.experiment_params import InspectionRunParams
from yarm.ros.inspection.node import InspectorNode, stopped_by_signals
from yarm.ros.inspection.params import Inspected, inspector_params
from yarm.ros.inspection.progress import progress_line
from yarm.sim.scenes.layout_file import find_layout
from yarm.yaml_fields import SceneError

RUN = "run"
"""Namespace of the run's own parameters below the inspector's."""
PROGRESS_S = 1.0
POLL_S = 0.1
JUDGE_LIMIT_S = 60.0
TOUCH_AGAIN_S = 0.5
"""A contact with the same body that comes back sooner is the same."""
CUT_SHORT = "the run was ended from outside"


class InspectionRun:
    """Follows the inspector from inside, pass by pass, and the truth by its topics."""

    def __init__(self, params: InspectionRunParams, given: Inspected) -> None:
        """Listen from now on.

        Raises:
            SceneError: the layout is faulty.
        """
        self._params, self._given = params, given
        self._layout = find_layout(params.layout)
        self._seed = self._layout.arena.seed if params.seed < 0 else params.seed
        self._over = False
        self._lock = threading.Condition()
        self._recorder = RoundRecorder()
        self._truth: Optional[Pose2] = None
        self._truth_s = -math.inf
        self._touching: Dict[str, float] = {}
        self._last: Optional[SessionStep] = None
        self._verdicts: Tuple[Verdict, ...] = ()
        self._started_s: Optional[float] = None
        self._computing_s = 0.0
        self._cpu_s = time.thread_time()
        self._now_s = self._moved_s = -1.0
        self._began = self._moved = time.monotonic()
        self._said_wall, self._said_s = 0.0, 0.0
        self.fault = ""
        self._subscribers = [
            rospy.Subscriber(names.SIM_POSE, OdometryMessage, self._on_truth, queue_size=100, tcp_nodelay=True),
            rospy.Subscriber(names.SIM_CONTACTS, Contacts, self._on_contacts, queue_size=1000),
        ]

    def passed(self, seen: Senses, step: SessionStep, verdicts: Tuple[Verdict, ...]) -> None:
        """A pass of the inspector; in lock-step the truth of that moment may still be on its way."""
        with self._lock:
            if self._given.params.sync:
                self._lock.wait_for(lambda: self._truth_s >= seen.now_s - 1e-6, self._given.params.sync_wait)
            self._now_s = seen.now_s
            if self._over:
                return
            self._last, self._verdicts = step, verdicts
            self._computing_s = time.thread_time() - self._cpu_s
            if step.step is None or step.observation is None or self._truth is None:
                return
            self._started_s = seen.now_s - step.elapsed_s
            observation, read = step.observation, step.action.read
            self._recorder.stepped(
                step.elapsed_s, replace(step.step, events=step.events), observation.outcome, observation.reason
            )
            self._recorder.passed(step.elapsed_s, self._truth, seen.pose)
            if read is not None:
                printed = self._given.params.controller == PRINTED
                self._recorder.looked(LookRecord.of(step.elapsed_s, read, printed))

    @property
    def folder(self) -> Path:
        """Of the results."""
        return Path(self._params.folder)

    def ended(self) -> bool:
        """Whether the round is over, or cannot go on; tells how it stands, at most once a second of wall time."""
        with self._lock:
            last, now_s = self._last, self._now_s
        self._tell(last, now_s)
        now = time.monotonic()
        if now_s > self._moved_s:
            self._moved_s, self._moved = now_s, now
        if self._started_s is None and now - self._began > self._params.start_limit_s:
            reason = "nothing heard" if last is None else last.reason
            self.fault = f"the round has not begun within {self._params.start_limit_s:.0f} s of wall time: {reason}"
        elif now - self._moved > self._params.stall_limit_s:
            self.fault = f"simulated time has stood still at {now_s:.1f} s for {self._params.stall_limit_s:.0f} s"
        over = last is not None and self._started_s is not None and last.step is None
        return bool(self.fault) or over

    def finish(self) -> Tuple[bool, str]:
        """Write the results; whether the round succeeded, and the table for the person at the terminal."""
        with self._lock:
            self._over = True
            record = self._record()
        if not record.path:
            return False, f"nothing was recorded: {self.fault or CUT_SHORT}"
        ended = self._last is not None and self._last.stage in {str(stage) for stage in ENDS}
        faults = tuple(filter(None, (self.fault or ("" if ended else CUT_SHORT),)))
        write_inspection(record, self._layout.arena, self.folder, parameters(), versions(), faults, self._given.tags)
        measures = measure(record)
        wrong = (*faults, *faults_of(record, measures))
        return not wrong, summary_table(record, measures, wrong)

    def _record(self) -> RoundRecord:
        step = self._last
        params = self._given.params
        stage = next((stage for stage in Stage if step is not None and str(stage) == step.stage), Stage.FAILED)
        end = (0.0, stage, self.fault) if step is None else (step.elapsed_s, stage, step.reason or self.fault)
        return self._recorder.finish(
            RoundInfo(
                self._layout.arena.name,
                params.controller,
                self._seed,
                "physics",
                params.time_limit_s,
                self._given.detector,
            ),
            end,
            tuple(boxes_of(self._layout)),
            dict(enumerate(self._layout.tags, start=1)),
            self._verdicts,
            self._computing_s,
        )

    def _tell(self, step: Optional[SessionStep], now_s: float) -> None:
        now = time.monotonic()
        if now - self._said_wall < PROGRESS_S:
            return
        rate = (now_s - self._said_s) / (now - self._said_wall) if self._said_wall and self._said_s > 0.0 else 0.0
        self._said_wall, self._said_s = now, now_s
        if step is None:
            say("waiting for the simulation")
            return
        say(progress_line(step, self._verdicts, len(self._given.boxes), f"x{rate:.2f}"))

    def _on_truth(self, message: OdometryMessage) -> None:
        with self._lock:
            self._truth, self._truth_s = pose2_of_pose(message.pose.pose), message.header.stamp.to_sec()
            self._lock.notify_all()

    def _on_contacts(self, message: Contacts) -> None:
        at_s = message.header.stamp.to_sec()
        with self._lock:
            touching = {body: seen_s for body, seen_s in self._touching.items() if at_s - seen_s < TOUCH_AGAIN_S}
            for contact in message.contacts:
                bodies = {contact.body_a, contact.body_b}
                others = bodies - {turtlebot.TYPE, "floor"}
                if turtlebot.TYPE not in bodies or len(others) != 1:
                    continue
                body = others.pop()
                if body not in touching and self._started_s is not None:
                    point = contact.point
                    self._recorder.touched(TouchRow(at_s - self._started_s, body, point.x, point.y))
                touching[body] = at_s
            self._touching = touching


def summary_table(record: RoundRecord, measures: Measures, wrong: Tuple[str, ...]) -> str:
    """For the person at the terminal: a line a box in visiting order, the figures, what is wrong."""
    rows = []
    for verdict in record.verdicts:
        read, truth = reading_words(verdict.reading.tag), reading_words(record.truth[verdict.box])
        mark = "right" if read == truth else f"it is {truth}"
        note = verdict.reason or verdict.reading.note or ("duplicate" if verdict.duplicate else "")
        rows.append(
            [str(verdict.box), read, f"{verdict.reading.probability:.4f}", mark, f"{verdict.found_s:.0f}", note]
        )
    info = record.info
    lines = [
        f"{info.layout}, {info.controller}, seed {info.seed}: {'FAILURE' if wrong else 'SUCCESS'}",
        markdown_table(("box", "tag", "probability", "", "at, s", ""), rows),
        f"{measures.right} of {measures.boxes} right, {measures.named_wrong} wrong tags, {measures.end_s:.0f} s, "
        f"{measures.distance_m:.1f} m, {measures.goals_failed} of {measures.goals} goals failed, "
        f"{measures.bumps} bumps, home within {measures.home_m:.3f} m and {math.degrees(measures.home_rad):.1f} deg",
        *wrong,
    ]
    return "\n".join(lines)


def judge(run: InspectionRun, filmer: Optional[Filmer]) -> bool:
    """Write what the round came to, and tell it; whether it succeeded."""
    success, table = run.finish()
    if filmer is not None:
        filmer.end().write(run.folder / FILM)
    say("\n" + table + f"\n\nresults, pictures and proof sheets: {run.folder.resolve()}")
    return success


class Judging:
    """Judges the first round while the inspector goes on, on a thread of its own."""

    def __init__(
        self, node: InspectorNode, run: InspectionRun, filmer: Optional[Filmer], stop: threading.Event
    ) -> None:
        """Begin.

        Args:
            node: whose round it is.
            run: follows it.
            filmer: takes its film.
            stop: set when the inspector is to end, with the round as it is then.
        """
        self._node, self._run, self._filmer, self._stop = node, run, filmer, stop
        self.success = False
        self._thread = threading.Thread(target=self._work, name="judge", daemon=True)
        self._thread.start()

    def wait(self) -> None:
        """Until the results are written, or for JUDGE_LIMIT_S."""
        self._thread.join(JUDGE_LIMIT_S)

    def _work(self) -> None:
        while not (self._run.ended() or self._stop.is_set()):
            time.sleep(POLL_S)
        self._node.unfollow()
        self.success = judge(self._run, self._filmer)


def main() -> int:
    """Run the node; exit code 0 only with every box right, home, in time."""
    init_node(names.INSPECTOR_NODE, disable_signals=True)
    stop = stopped_by_signals()
    try:
        values: Mapping[str, Any] = rospy.get_param("~", {})
        own = {name: value for name, value in values.items() if name != RUN}
        given = inspector_params(own, resource("scenes", "inspection", "practice_boxes.yaml"), rospy.get_name())
        params = build(InspectionRunParams, values.get(RUN, {}), f"{rospy.get_name()}/{RUN}")
        run = InspectionRun(params, given)
        filmer = filmer_of(f"{params.layout}/{params.seed}", params.film_hz)
        node = InspectorNode(given, stop, run)
        if params.once:
            node.run(run.ended)
            return 0 if judge(run, filmer) else 1
        judging = Judging(node, run, filmer, stop)
        node.run()
        judging.wait()
        return 0 if judging.success else 1
    except (ParamError, SceneError) as error:
        rospy.logfatal("%s", error)
        return 1
    finally:
        rospy.signal_shutdown("the round is over")
