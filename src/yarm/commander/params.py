"""Parameters of the Commander."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Tuple

from yarm.params import param
from yarm.planning.model.params import PlannerParams
from yarm.planning.registry import PLANNER_NAMES


class Removal(str, Enum):
    """What becomes of debris that a robot has reached, as parameter ``removal`` writes it."""

    DELETE = "delete"
    """It is deleted, as published."""
    BIN = "bin"
    """The robot's hand takes it to a bin."""


class CheckSteps(str, Enum):
    """What the independent checker's verdict on a plan does, as parameter ``check_steps`` writes it."""

    SEND_SAFE = "true"
    """Only what it passes is sent."""
    UNCHECKED = "false"
    """Everything is sent, and it is not asked."""
    REPORT = "report"
    """Everything is sent, and what it has against it is counted."""


@dataclass(frozen=True)
class CommanderParams:
    """Everything about the Commander that can be set."""

    sync: bool = param(False, "", "lock-step: acknowledge every camera set to the simulator")
    seed: int = param(1, "", "seed of the planner's random generator", low=0, high=2**31 - 1)
    planner: str = param(
        "yarm",
        "",
        "planner of the mission",
        choices=PLANNER_NAMES,
        form="module:Class",
    )
    particles: int = param(PlannerParams.particles, "", "particles of the planner, at least", low=3, high=20000)
    turns_deg: Tuple[float, ...] = param(
        PlannerParams.turns_deg, "deg", "turns about the end effector that robots may make", -180.0, 180.0
    )
    arrival_tolerance_m: float = param(0.06, "m", "within this of a column's centre counts as there", low=0.0, high=0.2)
    heading_tolerance_deg: float = param(3.0, "deg", "within this of a heading counts as there", low=0.1, high=45.0)
    settle_s: float = param(1.0, "s", "association stays off at least this long, so that clouds are learnt", low=0.0)
    calibration_timeout_s: float = param(180.0, "s", "longest wait for a robot's calibration", low=1.0, high=3600.0)
    cleanup_timeout_s: float = param(
        180.0, "s", "longest wait for a manipulator's way to storage", low=1.0, high=3600.0
    )
    server_timeout_s: float = param(10.0, "s", "longest wait for a robot's action server", low=0.5, high=600.0)
    cancel_timeout_s: float = param(5.0, "s", "longest wait for a cancelled goal to end", low=0.5, high=60.0)
    delete_timeout_s: float = param(5.0, "s", "longest wait for the deletion of a debris", low=0.5, high=60.0)
    stale_map_s: float = param(1.0, "s", "a map older than this stops every robot", low=0.1, high=60.0)
    no_progress_s: float = param(
        10.0, "s", "a robot that comes no nearer for this long is stopped", low=1.0, high=600.0
    )
    retry_s: float = param(1.0, "s", "pause before a failed goal or plan is tried again", low=0.0, high=60.0)
    replanning: bool = param(
        True, "", "plan again at every waypoint; false: each robot follows its first path to the end, as published"
    )
    check_steps: str = param(
        CheckSteps.SEND_SAFE.value,
        "",
        "true: send only what the independent checker passes; false: send everything, unchecked; "
        "report: send everything and count what it would have refused (the published planner as it was)",
        choices=[mode.value for mode in CheckSteps],
    )
    removal: str = param(
        Removal.DELETE.value,
        "",
        "what becomes of debris: delete: gone when reached, as published; bin: robots with a hand carry it to a bin",
        choices=[way.value for way in Removal],
    )
    hand_timeout_s: float = param(
        60.0, "s", "longest wait for a hand to pick a piece up or let it go", low=1.0, high=600.0
    )
    pick_tries: int = param(3, "", "tries to pick a piece up before it is given back", low=1, high=20)
    fall_s: float = param(0.5, "s", "a piece that was let go has come to rest after this long", low=0.0, high=10.0)
    bin_full_m: float = param(
        0.45, "m", "a bin is full when the middle of a piece in it lies higher over the floor", low=0.05, high=0.55
    )
    recheck_s: float = param(
        0.1, "s", "how often a step under way is checked against the newest map", low=0.0, high=10.0
    )
    recheck_count: int = param(
        3, "", "checks in a row that must fail before a step under way is stopped", low=1, high=100
    )
    linger_s: float = param(2.0, "s", "a mission without open tasks ends after this long", low=0.0, high=600.0)
    give_up_s: float = param(
        120.0, "s", "a mission with only unreachable goals fails after this long", low=1.0, high=36000.0
    )
    pause_distance_m: float = param(
        0.30, "m", "tip of a manipulator nearer than this to debris or a robot: OFF", low=0.0
    )
    resume_distance_m: float = param(0.40, "m", "farther than this: ON again", low=0.0)

    @property
    def checking(self) -> CheckSteps:
        """What ``check_steps`` says."""
        return CheckSteps(self.check_steps)

    @property
    def bins_used(self) -> bool:
        """Whether debris goes to a bin."""
        return self.removal == Removal.BIN

    @property
    def planner_params(self) -> PlannerParams:
        """What the planner and the task queue share."""
        return PlannerParams(particles=self.particles, turns_deg=self.turns_deg)
