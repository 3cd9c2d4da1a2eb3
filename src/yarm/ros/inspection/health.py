"""Says on /diagnostics how a node of the inspection does: one status, all complaints in it."""

from __future__ import annotations

from typing import Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from yarm.ros.common import names


class HealthReport:
    """Publishes the node's status."""

    def __init__(self) -> None:
        """Advertise."""
        self._publisher = rospy.Publisher(names.DIAGNOSTICS, DiagnosticArray, queue_size=10)

    def send(self, complaints: Sequence[str], well: str, severe: bool = False) -> None:
        """All is well when there is no complaint."""
        name = rospy.get_name().lstrip("/")
        status = DiagnosticStatus(name=name, hardware_id="none", level=DiagnosticStatus.OK, message=well)
        if complaints:
            status.level = DiagnosticStatus.ERROR if severe else DiagnosticStatus.WARN
            status.message = "; ".join(complaints)
        message = DiagnosticArray(status=[status])
        message.header.stamp = rospy.Time.now()
        self._publisher.publish(message)
