"""Lock-step acknowledgements: the one place where they are made."""

from __future__ import annotations

import rospy

from yarm.msg import StepAck


def step_ack(stamp: rospy.Time, commands_sent: int, results_sent: int = 0) -> StepAck:
    """This node is done with the camera set or tick of a stamp; it has sent so many commands and results so far."""
    ack = StepAck(node=rospy.get_name().rsplit("/", 1)[-1], commands_sent=commands_sent, results_sent=results_sent)
    ack.header.stamp = stamp
    return ack
