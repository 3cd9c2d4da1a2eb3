"""What a round is told and what it orders: goals for the navigation, turns, looks at a box."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Optional, Tuple, Union

from yarm.geometry import Pose2

OURS, REPORT, PRINTED = "yarm", "report", "report_printed"
CONTROLLERS = (OURS, REPORT, PRINTED)
"""Whose rounds can be driven."""


class Stage(str, Enum):
    """Where a round stands; equal to the word of InspectionStatus."""

    LOCALISE = "localise"
    PLAN = "plan"
    DRIVE = "drive"
    LOOK = "look"
    HOME = "home"
    DONE = "done"
    FAILED = "failed"

    def __str__(self) -> str:
        """The word."""
        return str(self.value)


ENDS = (Stage.DONE, Stage.FAILED)
"""A round in one of these has ended."""


@dataclass(frozen=True)
class Drive:
    """Go to a pose of the map by the navigation.

    Attributes:
        goal: pose of the base.
        limit_s: it has failed after this long.
    """

    goal: Pose2
    limit_s: float


@dataclass(frozen=True)
class Spin:
    """Turn in place.

    Attributes:
        angle_rad: how far, + = left.
        rate_radps: how fast.
    """

    angle_rad: float
    rate_radps: float


@dataclass(frozen=True)
class Look:
    """Look at a box from where the robot stands.

    Attributes:
        box: number of the box.
        images: so many at most.
        limit_s: no longer than this.
        pause_s: nothing is looked at for so long after an image.
    """

    box: int
    images: int
    limit_s: float
    pause_s: float = 0.0


@dataclass(frozen=True)
class ClearCostmaps:
    """What the navigation has seen in the way is forgotten."""


@dataclass(frozen=True)
class Stand:
    """Nothing is left to do."""


Order = Union[Drive, Spin, Look, ClearCostmaps, Stand]


class Outcome(str, Enum):
    """How the last order ended."""

    BUSY = "busy"
    DONE = "done"
    FAILED = "failed"


BLANK, UNKNOWN, UNSEEN = 0, -1, -2
"""Tag numbers that are none: an empty face, a picture that is no tag, a face that was not seen well enough."""


def reading_words(tag: int) -> str:
    """What was read, in one word: a tag's number, blank, unknown, none."""
    return {BLANK: "blank", UNKNOWN: "unknown", UNSEEN: "none"}.get(tag, str(tag))


@dataclass(frozen=True)
class Reading:
    """What looking at a box has told so far.

    Attributes:
        tag: from 1, or BLANK, UNKNOWN, UNSEEN.
        probability: that this is right, by everything seen of the box.
        moved_m: how far the box seems to stand from where it should; 0 when it does not.
        note: what else is wrong with it: missing, upside down; empty when nothing is.
    """

    tag: int = UNSEEN
    probability: float = 0.0
    moved_m: float = 0.0
    note: str = ""


@dataclass(frozen=True)
class Observation:
    """All a round is told at one pass.

    Attributes:
        now_s: time since the start, s.
        pose: of the base in the map; None while it is not known.
        localised: whether the localisation is sure of it.
        outcome: of the last order.
        reason: why it failed; empty otherwise.
        reading: of the box looked at last.
        start: where the round began, in the map as far as it is known now; None while nobody can tell.
    """

    now_s: float
    pose: Optional[Pose2] = None
    localised: bool = False
    outcome: Outcome = Outcome.BUSY
    reason: str = ""
    reading: Optional[Reading] = None
    start: Optional[Pose2] = None


@dataclass(frozen=True)
class Verdict:
    """How the visit to a box ended.

    Attributes:
        box: its number.
        pose: of the box as it was given.
        reading: what was read.
        duplicate: a box visited before bears the same tag.
        reason: why it has no verdict; empty when it has one.
        found_s: when, since the start.
    """

    box: int
    pose: Pose2
    reading: Reading
    duplicate: bool = False
    reason: str = ""
    found_s: float = 0.0


@dataclass(frozen=True)
class Event:
    """A line of events.csv: when, s, one word, and names with values."""

    t_s: float
    kind: str
    details: Tuple[Tuple[str, Union[str, int, float]], ...] = ()


@dataclass(frozen=True)
class Step:
    """One pass of a round.

    Attributes:
        order: what to do now; the same object as before while it is being done.
        stage: where the round stands.
        box: that it is about; 0 for none.
        events: what happened at this pass.
        reason: why it failed or stands; empty when all is well.
    """

    order: Order
    stage: Stage
    box: int = 0
    events: Tuple[Event, ...] = ()
    reason: str = ""
