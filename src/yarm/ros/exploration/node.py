"""Node ``explorer``: the loop of a session at 10 Hz of simulated time; services, status, map files.

The main thread owns the session. It is woken by ``/clock`` and makes a pass at every tenth of a second.
"""

from __future__ import annotations

import signal
import threading
import time
from functools import partial
from typing import Callable

import rospy
from std_msgs.msg import Bool
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from yarm.exploration.model import LOOP_S, Controller
from yarm.exploration.session import Answer, Request, Session
from yarm.params import ParamError
from yarm.ros.common import names
from yarm.ros.common.passes import Passes
from yarm.ros.common.start import init_node
from yarm.ros.exploration.inputs import ExplorerInputs
from yarm.ros.exploration.outputs import ExplorerOutputs
from yarm.ros.exploration.params import ExplorerParams, explorer_params
from yarm.ros.exploration.saver import Saver

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class ExplorerNode:
    """Ties topics and services to the session."""

    def __init__(self, params: ExplorerParams, make: Callable[[], Controller], stop: threading.Event) -> None:
        """Listen and advertise; nothing moves before :meth:`run`.

        Args:
            params: what the node is set to.
            make: makes a controller for a run.
            stop: set from outside to end :meth:`run`.
        """
        self._params = params
        self._stop = stop
        self._session_lock = threading.Lock()
        self._session = Session(params, make, params.autostart)
        self._saver = Saver(params.saves_as)
        self._outputs = ExplorerOutputs(params)
        self._inputs = ExplorerInputs(params)
        self._passes = Passes(LOOP_S, params.sync)
        self._resumes = rospy.Subscriber(names.EXPLORE_RESUME, Bool, self._on_resume, queue_size=10)
        self._services = [rospy.Service(f"~{r.value}", Trigger, partial(self._on_request, r)) for r in Request]

    def run(self) -> None:
        """Explore until the node is told to end; the map is saved then."""
        try:
            while not (self._stop.is_set() or rospy.is_shutdown()):
                if self._passes.take_reset():
                    self._start_afresh()
                now_s = self._passes.wait(self._together())
                if self._passes.take_repeated():
                    self._outputs.acknowledge(self._passes.at_s)
                if now_s is not None:
                    self._pass(now_s)
        finally:
            self._close()

    def _together(self) -> bool:
        """Lock-step begins when nothing that is said can be lost."""
        return not self._params.sync or (self._outputs.connected() and self._inputs.together())

    def _pass(self, now_s: float) -> None:
        began = time.thread_time()
        seen = self._inputs.observe(now_s)
        with self._session_lock:
            step = self._session.step(seen)
            lease = self._session.lease()
            keeper = self._session.keeper
        complaints = (*step.complaints, *self._inputs.complaints())
        self._outputs.status(step, lease, seen.pose, self._saver.saved, complaints)
        self._outputs.command(step, now_s)
        self._outputs.acknowledge(now_s)
        for order in step.saves:
            self._saver.save(order)
        self._outputs.took(1e3 * (time.thread_time() - began))
        self._outputs.pictures(now_s, step, seen, keeper.newest, keeper.count)
        for event in step.events:
            if event.kind in ("state", "sensor"):
                rospy.loginfo("%.1f s, %s: %s", event.t_s, event.kind, ", ".join(f"{k} {v}" for k, v in event.details))

    def _start_afresh(self) -> None:
        self._inputs.forget()
        self._outputs.forget()
        with self._session_lock:
            self._session.restart()

    def _close(self) -> None:
        with self._session_lock:
            order = self._session.last_order(self._passes.at_s)
        if order is not None:
            self._saver.save(order)
        self._saver.close()

    def _on_request(self, request: Request, _: TriggerRequest) -> TriggerResponse:
        answer = self._ask(request)
        return TriggerResponse(success=answer.success, message=answer.message)

    def _on_resume(self, message: Bool) -> None:
        answer = self._ask(Request.RESUME if message.data else Request.PAUSE)
        if not answer.success:
            rospy.logwarn("%s: %s", names.EXPLORE_RESUME, answer.message)

    def _ask(self, request: Request) -> Answer:
        with self._session_lock:
            return self._session.ask(request)


def main() -> int:
    """Run the node; signals only ask the loop to end, so that the map is saved first."""
    init_node(names.EXPLORER_NODE, disable_signals=True)
    stop = threading.Event()
    for number in SIGNALS:
        signal.signal(number, lambda *_: stop.set())
    try:
        params, make = explorer_params(rospy.get_param("~", {}), rospy.get_name())
        ExplorerNode(params, make, stop).run()
    except ParamError as error:
        rospy.logfatal("%s", error)
        return 1
    finally:
        rospy.signal_shutdown("the explorer has ended")
    return 0
