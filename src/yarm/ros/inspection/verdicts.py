"""Verdicts on boxes and pictures as messages."""

from __future__ import annotations

from typing import Mapping, Optional

import rospy

from yarm.inspection.model import UNSEEN, Verdict
from yarm.msg import TagVerdict
from yarm.ros.common.conversions import pose_message
from yarm.tags.evidence import ACCEPTING
from yarm.tags.evidence import TagVerdict as Evidence
from yarm.tags.free_look import FreeLook
from yarm.tags.recogniser import Finding


def free_verdict(look: FreeLook) -> TagVerdict:
    """What one picture shows of which nothing else is known."""
    message = TagVerdict(tag=UNSEEN, finding=Finding.NOT_SEEN.value, images=1, reason=look.reason)
    _put_scores(message, look.probabilities)
    if look.probabilities:
        message.tag = max(look.probabilities, key=lambda answer: look.probabilities[answer])
        message.probability = look.probabilities[message.tag]
        message.finding, message.places = Finding.IN_PLACE.value, 1
        if message.probability < ACCEPTING:
            message.reason = f"probability {message.probability:.4f}, final from {ACCEPTING}"
    return message


def box_verdict(verdict: Verdict, evidence: Optional[Evidence], stamp: rospy.Time, frame: str) -> TagVerdict:
    """How the visit to a box ended, with the evidence of ours where there is any."""
    reading = verdict.reading
    message = TagVerdict(box=verdict.box, tag=reading.tag, probability=reading.probability, reason=verdict.reason)
    message.header.stamp, message.header.frame_id = stamp, frame
    message.finding = reading.note or Finding.NOT_SEEN.value
    if evidence is not None:
        _put_scores(message, evidence.scores)
        message.finding, message.images, message.places = evidence.finding.value, evidence.images, evidence.places
        if evidence.measured is not None:
            stands = evidence.measured
            message.has_pose, message.pose = True, pose_message(stands.x, stands.y, 0.0, stands.yaw_rad)
    return message


def _put_scores(message: TagVerdict, scores: Mapping[int, float]) -> None:
    """Tags in the order of their numbers, then BLANK, then UNKNOWN."""
    message.answers = sorted(a for a in scores if a > 0) + sorted((a for a in scores if a <= 0), reverse=True)
    message.scores = [scores[answer] for answer in message.answers]
