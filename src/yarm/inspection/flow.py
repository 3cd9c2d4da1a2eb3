"""What every round is made of: a flow of orders, each standing until it has ended, and a verdict for each box."""

from __future__ import annotations

from typing import Generator, List, Optional, Sequence

from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.model import ENDS, Event, Observation, Order, Outcome, Reading, Stage, Stand, Step, Verdict
from yarm.inspection.viewpoints import Viewpoint

Flow = Generator[Step, Observation, Observation]
"""A part of a round: yields orders, is sent what came of each, and returns the last of it."""
WholeFlow = Generator[Step, Observation, None]


class RoundFlow:
    """A round over given boxes. It owns no clock and never waits: each pass gives the order that stands."""

    def __init__(self, boxes: Sequence[Box]) -> None:
        """Nothing visited yet."""
        self._boxes = {box.number: box for box in boxes}
        self._events: List[Event] = []
        self._flow: Optional[WholeFlow] = None
        self._last: Optional[Step] = None
        self._called_home = ""
        self.verdicts: List[Verdict] = []
        self.home: Optional[Pose2] = None

    def step(self, observation: Observation) -> Step:
        """One pass: the order to carry out now."""
        last = self._last
        if last is not None and last.stage in ENDS:
            return Step(Stand(), last.stage, reason=last.reason)
        if self._flow is None or last is None:
            return self._begin(self._round(observation))
        instead = self._instead(observation)
        if instead is not None:
            self._flow.close()
            return self._begin(instead)
        if observation.outcome == Outcome.BUSY:
            return Step(last.order, last.stage, last.box)
        self._last = self._flow.send(observation)
        return self._last

    def call_home(self, why: str) -> None:
        """From the next pass on it drives home; boxes that are left get this reason."""
        self._called_home = why

    def home_s(self, pose: Optional[Pose2]) -> float:
        """What the way home from a pose hardly ever exceeds, s; 0 while that is not known."""
        return 0.0

    def _begin(self, flow: WholeFlow) -> Step:
        self._flow, self._last = flow, next(flow)
        return self._last

    def _round(self, seen: Observation) -> WholeFlow:
        """The whole round."""
        raise NotImplementedError

    def _instead(self, seen: Observation) -> Optional[WholeFlow]:
        """What breaks off the round at this pass; None for going on."""
        return None

    def _say(self, order: Order, stage: Stage, box: int = 0, reason: str = "") -> Step:
        events = tuple(self._events)
        self._events.clear()
        return Step(order, stage, box, events, reason)

    def _note(self, seen: Observation, kind: str, **details: object) -> None:
        self._events.append(Event(seen.now_s, kind, tuple((key, str(value)) for key, value in details.items())))

    def _chosen(self, seen: Observation, view: Viewpoint, why: str) -> None:
        """A view of a box is gone to."""
        pose = view.pose
        place = {"x": round(pose.x, 4), "y": round(pose.y, 4), "yaw": round(pose.yaw_rad, 4)}
        self._note(
            seen, "viewpoint", box=view.box, distance_m=view.distance_m, angle_deg=view.angle_deg, **place, why=why
        )

    def _judge(self, box: Box, reading: Reading, seen: Observation, reason: str) -> None:
        """The visit to a box has ended."""
        again = reading.tag > 0 and any(verdict.reading.tag == reading.tag for verdict in self.verdicts)
        self.verdicts.append(Verdict(box.number, box.pose, reading, again, reason, seen.now_s))
        probability = round(reading.probability, 4)
        self._note(seen, "verdict", box=box.number, tag=reading.tag, probability=probability, reason=reason)
