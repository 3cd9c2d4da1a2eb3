"""Service ``safety/stop``: a person stops everything that moves, until it is released (docs/safety.md)."""

from __future__ import annotations

import threading
import xmlrpc.client
from typing import Callable, Tuple

import rosgraph
import rospy
from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

from yarm.ros.common import names

MASTER_FAULTS = (rosgraph.MasterException, xmlrpc.client.Error, OSError)
"""What a parameter may end in: a master that refuses, or that is gone."""


class StopService:
    """A latched stop. It is kept as a parameter, so that it outlives the node that serves it."""

    def __init__(self, changed: Callable[[], None]) -> None:
        """Take up the stop of a node that has died, and serve.

        Args:
            changed: called by the service's thread when ``reason`` has changed.
        """
        self._changed = changed
        self._lock = threading.Lock()
        self.reason = str(rospy.get_param(names.SAFETY_STOPPED_BY, "") or "")
        """Who stopped everything, when, and how it ends; empty while nothing is stopped."""
        if self.reason:
            rospy.logwarn("everything stays stopped: %s", self.reason)
        self._service = rospy.Service(names.SAFETY_STOP, SetBool, self._on_call)

    def _on_call(self, request: SetBoolRequest) -> SetBoolResponse:
        caller = request._connection_header.get("callerid", "unknown")
        with self._lock:
            return SetBoolResponse(*(self._stop(caller) if request.data else self._release(caller)))

    def _stop(self, caller: str) -> Tuple[bool, str]:
        """Robots first; what keeps the stop comes after."""
        fresh = not self.reason
        if fresh:
            service = self._service.resolved_name
            self.reason = f"stopped by {caller} at {rospy.get_time():.2f} s, until {service} is called with data: false"
        self._changed()
        if fresh:
            rospy.logwarn("%s", self.reason)
        try:
            rospy.set_param(names.SAFETY_STOPPED_BY, self.reason)
        except MASTER_FAULTS as error:
            return True, f"{self.reason}; it ends with {rospy.get_name()}, because it cannot be kept: {error}"
        return True, self.reason

    def _release(self, caller: str) -> Tuple[bool, str]:
        """A stop that would come back with the node's next start is not released."""
        if not self.reason:
            return True, "nothing was stopped"
        try:
            rospy.set_param(names.SAFETY_STOPPED_BY, "")
        except MASTER_FAULTS as error:
            return False, f"not released, because parameter {names.SAFETY_STOPPED_BY} cannot be cleared: {error}"
        before, self.reason = self.reason, ""
        self._changed()
        rospy.logwarn("released by %s; it was %s", caller, before)
        return True, f"released; it was {before}"
