"""Node ``camera_watch``: whether each overhead camera is still where it is told to be, with the correction when not.

It looks at one cloud a second of each camera, one after the other, and fits the camera's pose to the known static
bodies and the floor. Only a word on ``/diagnostics`` comes of it: what to do is for people.
"""

from __future__ import annotations

import math
import time
from typing import Dict

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from yarm.calibration.extrinsics import pick
from yarm.calibration.watch import ExtrinsicsWatch, WatchLimits, Word
from yarm.ros.calibration.params import CameraWatchParams
from yarm.ros.calibration.view import CellView, snapshot
from yarm.ros.common import names
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_node
from yarm.safety.pulse import beat_in_background

STATUS = "camera_watch: camera poses"
REPORT_PERIOD_S, PAUSE_S = 1.0, 0.05
"""Wall time between two words, and between two looks at the clock, s."""
LIMIT_S = 2.0
"""Wall time that a cloud is waited for, s."""


class CameraWatch:
    """Looks at the cameras in turn and says what it finds."""

    def __init__(self, params: CameraWatchParams) -> None:
        """Listen to who is where."""
        self._params = params
        limits = WatchLimits(
            params.window,
            params.named_shift,
            math.radians(params.named_turn),
            params.significance,
        )
        self._view = CellView()
        self._rng = np.random.default_rng(params.seed)
        self._watches = {topic: ExtrinsicsWatch(limits) for topic in params.camera_topics}
        self._words: Dict[str, Word] = {}
        self._silent: Dict[str, str] = {}
        self._looked_s: Dict[str, float] = {}
        self._clouds: Dict[str, int] = {}
        self._warned: Dict[str, bool] = {}
        self._diagnostics = rospy.Publisher(names.DIAGNOSTICS, DiagnosticArray, queue_size=10)

    def spin(self) -> None:
        """Look, judge and report until the node is shut down."""
        beat_in_background()
        report_s = time.monotonic()
        while not rospy.is_shutdown():
            for topic in self._params.camera_topics:
                if abs(rospy.get_time() - self._looked_s.get(topic, -math.inf)) >= self._params.cloud_period:
                    self._look(topic)
            if time.monotonic() >= report_s and not rospy.is_shutdown():
                self._report()
                report_s = time.monotonic() + REPORT_PERIOD_S
            time.sleep(PAUSE_S)

    def _look(self, topic: str) -> None:
        cloud = snapshot(topic, LIMIT_S)
        told = None if cloud.fault else self._view.pose_of(cloud.frame)
        if told is None:
            self._silent[topic] = cloud.fault or f"no transform from {names.WORLD_FRAME} to {cloud.frame}"
            return
        self._silent.pop(topic, None)
        self._looked_s[topic] = cloud.stamp_s
        self._clouds[topic] = self._clouds.get(topic, 0) + 1
        rows = pick(cloud.points, told, self._view.solids().static, self._rng, self._params.points)
        self._watches[topic].see(cloud.stamp_s, cloud.points[rows], told)
        if self._clouds[topic] % self._params.judge_every == 0:
            self._judge(topic)

    def _judge(self, topic: str) -> None:
        solids = self._view.solids()
        if solids.static:
            self._words[topic] = self._watches[topic].judge(solids.static, solids.moving)

    def _report(self) -> None:
        status = DiagnosticStatus(level=DiagnosticStatus.OK, name=STATUS, hardware_id="perception")
        said = []
        for topic in self._params.camera_topics:
            word = self._words.get(topic)
            off = word is not None and word.off
            if word is not None and off:
                said.append(f"{topic} is off: {word.text}")
                if not self._warned.get(topic):
                    rospy.logwarn("%s; check its mounting, or rosrun yarm calibrate_cameras", said[-1])
            self._warned[topic] = off
            known = word.text if word is not None else "not judged yet"
            status.values.append(KeyValue(topic, self._silent.get(topic, known)))
            if word is not None and word.known:
                status.values.append(KeyValue(f"{topic} significance", f"{word.refined.significance:.2f}"))
                status.values.append(KeyValue(f"{topic} off surfaces by, m (median)", f"{word.refined.before_m:.4f}"))
        if said:
            status.level = DiagnosticStatus.WARN
        status.message = "; ".join(said) or "no camera is off, of those that can be judged"
        array = DiagnosticArray(status=[status])
        array.header.stamp = rospy.Time.now()
        self._diagnostics.publish(array)


def main() -> None:
    """Run the node until it is shut down."""
    init_node("camera_watch")
    CameraWatch(load_params(CameraWatchParams)).spin()
