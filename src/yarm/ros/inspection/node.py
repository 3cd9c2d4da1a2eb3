"""Node ``inspector``: the loop of a session at 10 Hz of simulated time; services, status, the result file.

The main thread owns the session. What it reads of boxes it reads itself, from the pictures it takes while it stands.
"""

from __future__ import annotations

import signal
import threading
import time
from functools import partial
from typing import Callable, Optional, Protocol, Sequence, Tuple

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from yarm.experiments.inspect.pilot import Ways
from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Scan
from yarm.inspection.flow import RoundFlow
from yarm.inspection.model import ENDS, OURS, PRINTED, Stage, Verdict
from yarm.inspection.printed_round import PrintedRound
from yarm.inspection.readers import Reader, make_reader
from yarm.inspection.reading import chances
from yarm.inspection.report_round import ReportRound
from yarm.inspection.round import Round
from yarm.inspection.senses import Senses
from yarm.inspection.session import IDLE, LOOP_S, InspectionSession, Request, SessionStep
from yarm.inspection.start_place import fitted
from yarm.navigation.bodies import with_bodies
from yarm.params import ParamError
from yarm.resources import resource
from yarm.ros.common import names
from yarm.ros.common.passes import Passes
from yarm.ros.common.start import init_node
from yarm.ros.inspection.inputs import InspectorInputs
from yarm.ros.inspection.navigation_link import NavigationLink
from yarm.ros.inspection.outputs import InspectorOutputs
from yarm.ros.inspection.params import Inspected, inspector_params
from yarm.ros.inspection.progress import progress_line
from yarm.tags.chance import LookChance

SIGNALS = (signal.SIGINT, signal.SIGTERM)
SAVE = "save"
PROGRESS_S = 1.0
"""Between two lines of how a round goes."""
WAITING_S = 10.0
"""Between two lines of what a round waits for, from when that is a trouble."""
TOLD = ("verdict", "failed", "trouble", "hopeless", "stopped")
"""Kinds of events that are told on the console."""


class Observer(Protocol):
    """Somebody who follows the rounds from inside, for instance to keep a record."""

    def passed(self, seen: Senses, step: SessionStep, verdicts: Tuple[Verdict, ...]) -> None:
        """A pass, after it was decided and before it is acknowledged."""


class KnownMap:
    """The map with the known boxes in it, as it is now, and ways over it."""

    def __init__(self, given: Inspected, inputs: InspectorInputs) -> None:
        """Nothing drawn yet."""
        self._outlines = [box.corners() for box in given.boxes]
        self._inputs = inputs
        self._count = -1
        self._ways: Optional[Ways] = None

    def lengths(self, start: Pose2, goals: Sequence[Pose2]) -> FloatArray:
        """(n,) metres to each goal; inf without a way."""
        return self._now().lengths(start, goals)

    def gap(self, x: float, y: float) -> float:
        """From a point to the nearest body, metres; 0 outside the map."""
        return self._now().gap(x, y)

    def fitted(self, guess: Pose2, scan: Scan) -> Pose2:
        """The pose near a guess from which a scan fits the map best."""
        return fitted(guess, scan, self._now().grid)

    def _now(self) -> Ways:
        grid = self._inputs.map
        assert grid is not None
        if self._ways is None or self._count != self._inputs.map_count:
            self._count = self._inputs.map_count
            self._ways = Ways(with_bodies(grid, self._outlines))
        return self._ways


class InspectorNode:
    """Ties topics, services and the navigation to the session."""

    def __init__(self, given: Inspected, stop: threading.Event, observer: Optional[Observer] = None) -> None:
        """Listen and advertise; nothing moves before :meth:`run`.

        Args:
            given: parameters, boxes and tags.
            stop: set from outside to end :meth:`run`.
            observer: follows every pass.
        """
        self._given, self._params = given, given.params
        self._stop, self._observer = stop, observer
        self._lock = threading.Lock()
        self._navigation = NavigationLink(self._params.map_frame)
        self._inputs = InspectorInputs(self._params, self._navigation, given.boxes)
        self._outputs = InspectorOutputs(given)
        self._known = KnownMap(given, self._inputs)
        self._round: Optional[RoundFlow] = None
        self._reader: Optional[Reader] = None
        self._session = InspectionSession(self._params.session, self._make, self._known.fitted)
        self._passes = Passes(LOOP_S, self._params.sync)
        self._told_s = 0.0
        self._services = [rospy.Service(f"~{r.value}", Trigger, partial(self._on_request, r)) for r in Request]
        self._services.append(rospy.Service(f"~{SAVE}", Trigger, self._on_save))

    def run(self, ended: Callable[[], bool] = lambda: False) -> None:
        """Inspect until the node is told to end; the result is written then, and the robot stands."""
        try:
            while not (self._stop.is_set() or rospy.is_shutdown() or ended()):
                if self._passes.take_reset():
                    self._start_afresh()
                now_s = self._passes.wait(self._together())
                if self._params.sync and self._passes.take_repeated():
                    self._outputs.acknowledge(self._passes.at_s)
                if now_s is not None:
                    self._pass(now_s)
        finally:
            self._close()

    def unfollow(self) -> None:
        """Nobody follows the rounds any more: the node tells itself how they go."""
        self._observer = None

    def _together(self) -> bool:
        """Lock-step begins when nothing that is said can be lost."""
        if not self._params.sync:
            return True
        return self._outputs.connected() and self._navigation.connected() and self._inputs.together()

    def _pass(self, now_s: float) -> None:
        began = time.perf_counter()
        observer = self._observer
        seen = self._inputs.observe(now_s)
        with self._lock:
            step = self._session.step(seen)
            verdicts, home = self._session.verdicts, self._session.home
        self._act(now_s, step)
        self._outputs.verdicts(now_s, verdicts, self._reader)
        self._outputs.status(now_s, step, seen.pose)
        if observer is not None:
            observer.passed(seen, step, verdicts)
        tour = self._round.tour if isinstance(self._round, Round) else ()
        self._outputs.pictures(now_s, step, verdicts, seen.pose, home, tour)
        self._outputs.took(1e3 * (time.perf_counter() - began))
        self._outputs.acknowledge(now_s)
        for event in step.events:
            if event.kind in TOLD:
                details = ", ".join(f"{key} {value}" for key, value in event.details)
                rospy.loginfo("%.1f s, %s: %s", event.t_s, event.kind, details)
        if observer is None:  # an experiment tells it itself, with the rate of time
            self._tell(step, verdicts)

    def _tell(self, step: SessionStep, verdicts: Sequence[Verdict]) -> None:
        """How the round goes, how it has ended, or what it waits for in vain."""
        ended = step.step is not None and step.stage in ENDS
        if ended or (step.elapsed_s > 0.0 and abs(step.elapsed_s - self._told_s) >= PROGRESS_S):
            self._told_s = step.elapsed_s
            tell = rospy.logwarn if step.stage == Stage.FAILED else rospy.loginfo
            tell("%s", progress_line(step, verdicts, len(self._given.boxes)))
        if step.stage == IDLE and step.complaints:
            rospy.logwarn_throttle(WAITING_S, f"no round has begun: {step.reason}")

    def _act(self, now_s: float, step: SessionStep) -> None:
        action = step.action
        if action.cancel:
            self._navigation.cancel(now_s)
        if action.clear:
            self._navigation.clear_costmaps()
        self._outputs.turn(action.turn_radps)
        if action.goal is not None:
            self._navigation.send(action.goal, now_s)

    def _make(self) -> Tuple[RoundFlow, Reader]:
        boxes, controller = self._given.boxes, self._params.controller
        self._reader = make_reader(controller, boxes, self._given.tags, self._params.sure, self._given.detector)
        if controller == OURS:
            chance = chances(boxes, LookChance())
            self._round = Round(boxes, self._known.lengths, chance, self._params.round, self._known.gap)
        elif controller == PRINTED:
            self._round = PrintedRound(boxes, self._navigation.plannable, self._given.report)
        else:
            self._round = ReportRound(boxes, self._navigation.plannable, self._known.gap, self._given.report)
        return self._round, self._reader

    def _start_afresh(self) -> None:
        self._inputs.forget()
        self._navigation.forget()
        self._outputs.forget()
        with self._lock:
            self._session.restart("time went backwards; waits for ~start")

    def _close(self) -> None:
        """The robot stands, and what is known is on disk."""
        self._navigation.cancel(self._passes.at_s)
        self._outputs.turn(0.0)
        with self._lock:
            verdicts = self._session.verdicts
        if verdicts:
            self._outputs.save(verdicts)

    def _on_request(self, request: Request, _: TriggerRequest) -> TriggerResponse:
        with self._lock:
            answer = self._session.ask(request)
        return TriggerResponse(success=answer.success, message=answer.message)

    def _on_save(self, _: TriggerRequest) -> TriggerResponse:
        with self._lock:
            verdicts = self._session.verdicts
        fault = self._outputs.save(verdicts)
        return TriggerResponse(success=not fault, message=fault or f"{len(verdicts)} verdicts: {self._outputs.saved}")


def stopped_by_signals() -> threading.Event:
    """An event that SIGINT and SIGTERM set, instead of ending the process."""
    stop = threading.Event()
    for number in SIGNALS:
        signal.signal(number, lambda *_: stop.set())
    return stop


def read_given() -> Inspected:
    """The node's own parameters and files.

    Raises:
        ParamError: everything that is wrong, at once.
    """
    practice = resource("scenes", "inspection", "practice_boxes.yaml")
    return inspector_params(rospy.get_param("~", {}), practice, rospy.get_name())


def main() -> int:
    """Run the node; signals only ask the loop to end, so that the robot stands and the result is written first."""
    init_node(names.INSPECTOR_NODE, disable_signals=True)
    stop = stopped_by_signals()
    try:
        InspectorNode(read_given(), stop).run()
    except ParamError as error:
        rospy.logfatal("%s", error)
        return 1
    finally:
        rospy.signal_shutdown("the inspector has ended")
    return 0
