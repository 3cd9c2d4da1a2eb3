"""What the page asks of the system: services, and why one does not answer."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import rospy
from std_srvs.srv import SetBool

from yarm.commander.requests import Request
from yarm.console.cell import Answer
from yarm.ros.common import names
from yarm.srv import StateChange, Why

STOPPERS = f"{names.SAFETY_NODE} (in a room {names.GATE_NODE}, on the youBot's floor {names.YOUBOT_NODE})"
"""Who serves the stop."""


class RosCell:
    """A running system by its public services. Thread-safe: each call makes a connection of its own."""

    def change_state(self, request: Request) -> Answer:
        """Ask the Commander for a change of state."""
        return _call(names.COMMANDER_STATE, StateChange, names.COMMANDER_NODE, **asdict(request))

    def stop(self) -> Answer:
        """Stop everything that moves, until ``release``."""
        return _call(names.SAFETY_STOP, SetBool, STOPPERS, data=True)

    def release(self) -> Answer:
        """Let it move again."""
        return _call(names.SAFETY_STOP, SetBool, STOPPERS, data=False)

    def why(self, subject: str) -> Answer:
        """Why a goal is not served, or a robot stands."""
        return _call(names.COMMANDER_WHY, Why, names.COMMANDER_NODE, subject=subject)


def _call(service: str, kind: Any, server: str, **fields: Any) -> Answer:
    try:
        answer = rospy.ServiceProxy(service, kind)(**fields)
    except (rospy.ServiceException, rospy.ROSException, OSError) as error:
        return Answer(False, f"{service} does not answer: {error}; is {server} running?")
    return Answer(bool(answer.success), str(getattr(answer, "message", "") or getattr(answer, "text", "")))
