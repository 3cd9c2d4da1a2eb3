"""What several images of one box come to: images from one place are one opinion, other places are further ones."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Mapping, Optional, Tuple

from yarm.geometry import Pose2, wrap_angle
from yarm.tags.calibration import BLANK, UNKNOWN
from yarm.tags.recogniser import Finding, Look, Status

ACCEPTING = 0.999
"""A verdict is final from this probability on."""
SAME_PLACE_M, SAME_PLACE_DEG = 0.10, 10.0
LEAST_PROBABILITY = 1e-5
"""No single place's opinion counts for more than this: what misleads it is not all in the model."""


@dataclass(frozen=True)
class TagVerdict:
    """The verdict on one box.

    Attributes:
        box: number of the box.
        answer: number of the tag, BLANK or UNKNOWN; None when no image could be judged.
        probability: of the answer; 0 without one.
        scores: probability of each tag, of BLANK and of UNKNOWN; empty without an answer.
        finding: how the box stands, by the latest image that says so.
        measured: where it stands, by the latest image that shows its tag.
        images: images looked at.
        places: different places they were taken from, of those that could be judged.
        reason: why there is no answer, or that it is not sure yet; empty when it is final.
        accepting: probability from which on it is final.
    """

    box: int
    answer: Optional[int]
    probability: float
    scores: Mapping[int, float]
    finding: Finding
    measured: Optional[Pose2]
    images: int
    places: int
    reason: str
    accepting: float = ACCEPTING

    @property
    def final(self) -> bool:
        """Whether no further look is needed."""
        return self.answer is not None and self.probability >= self.accepting

    @property
    def text(self) -> str:
        """The answer in words."""
        if self.answer is None:
            return "none"
        return {BLANK: "blank", UNKNOWN: "unknown"}.get(self.answer, str(self.answer))


class BoxEvidence:
    """Gathers the looks at one box.

    Within 0.10 m and 10 degrees the mean of the looks' log probabilities counts, so that many frames of a standing
    robot weigh as much as one; the sums of different places are added.
    """

    def __init__(self, box: int, accepting: float = ACCEPTING) -> None:
        """Nothing has been seen of a box; its verdict is to be final from this probability on."""
        self.box = box
        self._accepting = accepting
        self._places: List[Tuple[Pose2, List[Look]]] = []
        self._looks: List[Look] = []

    def add(self, look: Look, robot: Pose2) -> None:
        """Take in a look from a robot's pose."""
        self._looks.append(look)
        if not look.probabilities:
            return
        for place, looks in self._places:
            turn = abs(math.degrees(wrap_angle(place.yaw_rad - robot.yaw_rad)))
            if place.distance(robot) <= SAME_PLACE_M and turn <= SAME_PLACE_DEG:
                looks.append(look)
                return
        self._places.append((robot, [look]))

    def verdict(self) -> TagVerdict:
        """What is known so far."""
        stands = [look for look in self._looks if look.finding is not Finding.NOT_SEEN]
        finding = stands[-1].finding if stands else Finding.NOT_SEEN
        measured = next((look.measured for look in reversed(self._looks) if look.measured is not None), None)
        if not self._places:
            return TagVerdict(self.box, None, 0.0, {}, finding, measured, len(self._looks), 0, self._why_none())
        scores = self._scores()
        answer = max(scores, key=lambda a: scores[a])
        probability = scores[answer]
        sure, final = probability >= self._accepting, f"final from {self._accepting:g}"
        reason = "" if sure else f"probability {probability:.4f}, {final}: look from another place"
        seen = (len(self._looks), len(self._places))
        return TagVerdict(self.box, answer, probability, scores, finding, measured, *seen, reason, self._accepting)

    def _scores(self) -> Dict[int, float]:
        sums: Dict[int, float] = {}
        for _, looks in self._places:
            for answer in looks[0].probabilities:
                logs = [math.log(max(look.probabilities[answer], LEAST_PROBABILITY)) for look in looks]
                sums[answer] = sums.get(answer, 0.0) + sum(logs) / len(logs)
        most = max(sums.values())
        powers = {answer: math.exp(value - most) for answer, value in sums.items()}
        whole = sum(powers.values())
        return {answer: power / whole for answer, power in powers.items()}

    def _why_none(self) -> str:
        if not self._looks:
            return "no image has come"
        last = self._looks[-1]
        return last.reason or (last.status.value if last.status is not Status.LOOKED else last.finding.value)
