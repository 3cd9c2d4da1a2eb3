"""What the inspector says: status, verdicts, turns in place, diagnostics, pictures for RViz, the result file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import List, Optional, Sequence

import rospy
from geometry_msgs.msg import Twist

from yarm.geometry import Pose2
from yarm.inspection.model import Verdict
from yarm.inspection.readers import Reader
from yarm.inspection.result_file import lines_of
from yarm.inspection.session import SessionStep
from yarm.inspection.viewpoints import Viewpoint
from yarm.msg import InspectionStatus, StepAck, TagVerdict
from yarm.ros.commander.reports import exact_time
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.conversions import pose_message
from yarm.ros.common.pictures import Picture
from yarm.ros.inspection.drawing import box_markers, state_marker, way_markers
from yarm.ros.inspection.health import HealthReport
from yarm.ros.inspection.params import Inspected
from yarm.ros.inspection.verdicts import box_verdict

PICTURE_PERIOD_S, HEALTH_PERIOD_S = 0.5, 1.0
BOX_HEIGHT_M = 0.40
"""Of the boxes as they are drawn."""


class InspectorOutputs:
    """Publishers; called from the loop alone."""

    def __init__(self, given: Inspected) -> None:
        """Advertise everything."""
        self._given, self._params = given, given.params
        advertise = rospy.Publisher
        self._status = advertise("~status", InspectionStatus, queue_size=10, latch=True, tcp_nodelay=True)
        self._verdict = advertise("~verdict", TagVerdict, queue_size=100)
        self._turn = advertise(names.NAVI, Twist, queue_size=10, tcp_nodelay=True)
        self._ack = advertise(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)
        self._markers = Picture("~markers", self._params.map_frame)
        self._health = HealthReport()
        self.saved = ""
        """File of the result written last."""
        self.forget()

    def forget(self) -> None:
        """Time went backwards: nothing sent, nothing drawn."""
        self._sent = 0
        self._picture_s = self._health_s = -1.0
        self._took_ms = 0.0
        self._messages: List[TagVerdict] = []

    def connected(self) -> bool:
        """Somebody hears the turns and the acknowledgements."""
        return all(int(publisher.get_num_connections()) > 0 for publisher in (self._turn, self._ack))

    def turn(self, rate_radps: Optional[float]) -> None:
        """Have the base turn; nothing is said without a rate."""
        if rate_radps is None:
            return
        message = Twist()
        message.angular.z = rate_radps
        self._turn.publish(message)
        self._sent += 1

    def took(self, ms: float) -> None:
        """How long a pass took, ms of wall time."""
        self._took_ms = ms

    def acknowledge(self, now_s: float) -> None:
        """Lock-step: this pass is done."""
        if self._params.sync:
            self._ack.publish(step_ack(exact_time(now_s), self._sent))

    def verdicts(self, now_s: float, verdicts: Sequence[Verdict], reader: Optional[Reader]) -> None:
        """Say what is new, and write the result file anew."""
        if len(verdicts) < len(self._messages):
            self._messages = []
        fresh = verdicts[len(self._messages) :]
        for verdict in fresh:
            evidence = None if reader is None else reader.evidence(verdict.box)
            message = box_verdict(verdict, evidence, exact_time(now_s), self._params.map_frame)
            self._messages.append(message)
            self._verdict.publish(message)
        if fresh:
            self.save(verdicts)

    def save(self, verdicts: Sequence[Verdict]) -> str:
        """Write the result so far; why that failed, or empty."""
        lines = lines_of(self._params.controller, verdicts)
        path = self._params.result_path
        try:
            write_whole(path, "\n".join(lines) + "\n")
        except OSError as error:
            rospy.logerr("the result is not written: %s: %s", path, error.strerror)
            return f"{path}: {error.strerror}"
        self.saved = str(path)
        return ""

    def status(self, now_s: float, step: SessionStep, here: Optional[Pose2]) -> None:
        """Where the round stands."""
        message = InspectionStatus(
            stage=step.stage,
            box=step.box,
            elapsed=step.elapsed_s,
            left=step.left_s,
            time_home=step.time_home_s,
            verdicts=list(self._messages),
            reason=step.reason,
            sensors=[complaint.text for complaint in step.complaints],
            saved=self.saved,
            has_pose=here is not None,
            pass_ms=self._took_ms,
        )
        message.header.stamp, message.header.frame_id = exact_time(now_s), self._params.map_frame
        if here is not None:
            message.pose = pose_message(here.x, here.y, 0.0, here.yaw_rad)
        self._status.publish(message)
        if now_s - self._health_s >= HEALTH_PERIOD_S:
            self._health_s = now_s
            texts = [complaint.text for complaint in step.complaints]
            self._health.send(texts, step.stage, severe=step.stage == "failed")

    def pictures(
        self,
        now_s: float,
        step: SessionStep,
        verdicts: Sequence[Verdict],
        here: Optional[Pose2],
        home: Optional[Pose2],
        tour: Sequence[Viewpoint],
    ) -> None:
        """Everything drawn, twice a second."""
        if not self._params.visualize or now_s - self._picture_s < PICTURE_PERIOD_S:
            return
        self._picture_s = now_s
        boxes = self._given.boxes
        found = {verdict.box: verdict for verdict in verdicts}
        made = box_markers(boxes, found, step.box, BOX_HEIGHT_M)
        made += way_markers(here, home, [view for view in tour if view.box not in found])
        made.append(state_marker(step, len(verdicts), len(boxes), self._params.base_frame))
        self._markers.send(made, now_s)


def write_whole(path: Path, text: str) -> None:
    """Write a file so that a reader never finds half of it.

    Raises:
        OSError: it cannot be written.
    """
    part = path.with_name(path.name + ".part")
    part.write_text(text)
    os.replace(part, path)
