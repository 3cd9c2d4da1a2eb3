"""Parameters of the Commander."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Tuple

from yarm.params import param
from yarm.planning.model.hidden import HiddenParams, HiddenPolicy
from yarm.planning.model.params import PlannerParams
from yarm.planning.registry import PLANNER_NAMES
from yarm.robots.turns import FINER_TURNS_DEG


class Removal(str, Enum):
    """What becomes of debris that a robot has reached, as parameter ``removal`` writes it."""

    DELETE = "delete"
    """It is deleted, as published."""
    BIN = "bin"
    """The robot's hand takes it to a bin."""


class Execution(str, Enum):
    """How a plan is carried out, as parameter ``execution`` writes it."""

    STEPS = "steps"
    """Everybody waits until all have arrived."""
    CONTINUOUS = "continuous"
    """A robot goes on as soon as nobody is left that its next move would touch."""


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
    particles: int = param(PlannerParams.particles, "", "particles of a search at most", low=3, high=20000)
    particles_first: int = param(
        PlannerParams.particles_first, "", "of these the ones that a search begins with", low=3, high=20000
    )
    turns_deg: Tuple[float, ...] = param(
        PlannerParams.turns_deg, "deg", "turns about the end effector that robots may make", -180.0, 180.0
    )
    finer_turns_deg: Tuple[float, ...] = param(
        FINER_TURNS_DEG,
        "deg",
        "further turns, for the rest of a mission, once nothing is left but goals to which turns_deg leads nobody, "
        "or nobody moves; empty: none",
        -180.0,
        180.0,
    )
    finer_after_s: float = param(
        10.0, "s", "a mission in which nobody finds a way takes finer_turns_deg after this long", low=0.0, high=36000.0
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
    execution: str = param(
        Execution.CONTINUOUS.value,
        "",
        "steps: everybody waits until all have arrived, then a step is planned for all; "
        "continuous: a robot goes on as soon as every earlier move that its next one conflicts with has ended",
        choices=[way.value for way in Execution],
    )
    plan_delay_s: float = param(
        0.1, "s", "with `execution` continuous: a plan takes effect this long after it was asked for", low=0.0, high=5.0
    )
    check_steps: str = param(
        CheckSteps.SEND_SAFE.value,
        "",
        "true: send only what the independent checker passes; false: send everything, unchecked; "
        "report: send everything and count what it would have refused (the published planner as it was)",
        choices=[mode.value for mode in CheckSteps],
    )
    hidden: str = param(
        HiddenPolicy.FREE.value,
        "",
        "cells that no camera sees: free, as published; known_bodies: free while nothing unregistered can be there, "
        "and seen not long ago or hidden by registered bodies alone; occupied; all but free need visibility of "
        "merge_clouds",
        choices=[policy.value for policy in HiddenPolicy],
    )
    hidden_age_s: float = param(
        HiddenParams.age_s, "s", "a cell hidden by more than registered bodies is free this long", low=0.0, high=3600.0
    )
    hidden_speed_mps: float = param(
        HiddenParams.speed_m_s, "m/s", "nothing unregistered moves faster than this", low=0.0, high=20.0
    )
    hidden_least_m: float = param(
        HiddenParams.least_m, "m", "hidden things are at least so large every way, 0: of any size", low=0.0, high=2.0
    )
    starts_clear: bool = param(
        HiddenParams.starts_clear,
        "",
        "nothing unregistered is in the cell at the start, nor ever where no camera looks",
    )
    fenced: bool = param(
        HiddenParams.fenced, "", "nothing comes in from outside behind registered bodies that alone hide the border"
    )
    people_s: float = param(
        1.4,
        "s",
        "no step is planned where somebody who moves may be within this time: what a robot at 1 m/s needs to stand, "
        "and 0.5 s; 0: people are where the map shows them",
        low=0.0,
        high=5.0,
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
    sand_elsewhere: bool = param(
        False, "", "manipulators are told where debris and robots are, or will be, and sand elsewhere meanwhile"
    )

    @property
    def checking(self) -> CheckSteps:
        """What ``check_steps`` says."""
        return CheckSteps(self.check_steps)

    @property
    def bins_used(self) -> bool:
        """Whether debris goes to a bin."""
        return self.removal == Removal.BIN

    @property
    def hidden_params(self) -> HiddenParams:
        """How cells that no camera sees are judged."""
        told = self.starts_clear, self.fenced
        return HiddenParams(
            HiddenPolicy(self.hidden), self.hidden_age_s, self.hidden_speed_mps, self.hidden_least_m, *told
        )

    @property
    def planner_params(self) -> PlannerParams:
        """What the planner and the task queue share."""
        return PlannerParams(self.particles, self.particles_first, turns_deg=self.turns_deg)
