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
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from yarm.exploration.model import LOOP_S, Controller
from yarm.exploration.session import Answer, Request, Session
from yarm.params import ParamError
from yarm.ros.common import names
from yarm.ros.common.clock import ClockWatch
from yarm.ros.common.start import init_node
from yarm.ros.exploration.inputs import ExplorerInputs
from yarm.ros.exploration.outputs import ExplorerOutputs
from yarm.ros.exploration.params import ExplorerParams, explorer_params
from yarm.ros.exploration.saver import Saver

WAKE_S = 0.2
"""Wall time after which the loop looks whether it is to end, s."""
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
        self._tick = threading.Condition()
        self._now_s, self._at_s, self._due = 0.0, 0.0, 0
        self._went_back = self._again = False
        self._session_lock = threading.Lock()
        self._session = Session(params, make, params.autostart)
        self._saver = Saver(params.saves_as)
        self._outputs = ExplorerOutputs(params)
        self._inputs = ExplorerInputs(params)
        self._clock = ClockWatch()
        self._clock.on_reset(self._on_clock_reset)
        self._subscribers = [
            rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=100, tcp_nodelay=True),
            rospy.Subscriber(names.EXPLORE_RESUME, Bool, self._on_resume, queue_size=10),
        ]
        self._services = [rospy.Service(f"~{r.value}", Trigger, partial(self._on_request, r)) for r in Request]

    def run(self) -> None:
        """Explore until the node is told to end; the map is saved then."""
        try:
            while not (self._stop.is_set() or rospy.is_shutdown()):
                if self._await_pass():
                    self._pass()
        finally:
            self._close()

    def _await_pass(self) -> bool:
        """Wait for the next tenth of a second; false when it has not come yet."""
        with self._tick:
            if self._went_back:
                self._went_back, self._due = False, 0
                self._start_afresh()
            if self._passes_now() < self._due:
                self._tick.wait(WAKE_S)
            count = self._passes_now()
            if self._params.sync and count + 1 == self._due and self._again:
                self._again = False
                self._outputs.acknowledge(self._at_s)
            if count < self._due or self._now_s <= 0.0 or not self._together():
                return False
            self._at_s = count * LOOP_S if self._params.sync else self._now_s
            self._due, self._again = count + 1, False
            return True

    def _passes_now(self) -> int:
        """Tenths of a second that have begun."""
        return int(round(self._now_s / LOOP_S, 6))

    def _together(self) -> bool:
        """Lock-step begins when nothing that is said can be lost."""
        return not self._params.sync or (self._outputs.connected() and self._inputs.together())

    def _pass(self) -> None:
        began, now_s = time.perf_counter(), self._at_s
        seen = self._inputs.observe(now_s)
        with self._session_lock:
            step = self._session.step(seen)
            lease = self._session.lease()
            keeper = self._session.keeper
        self._outputs.status(step, lease, seen.pose, self._saver.saved)
        self._outputs.command(step, now_s)
        self._outputs.acknowledge(now_s)
        for order in step.saves:
            self._saver.save(order)
        self._outputs.took(1e3 * (time.perf_counter() - began))
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
            order = self._session.keeper.order(self._now_s, "the node ends")
        if order is not None:
            self._saver.save(order)
        self._saver.close()

    def _on_clock(self, message: Clock) -> None:
        with self._tick:
            self._again = message.clock.to_sec() == self._now_s
            self._now_s = message.clock.to_sec()
            self._tick.notify_all()

    def _on_clock_reset(self) -> None:
        with self._tick:
            self._went_back = True
            self._tick.notify_all()

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
