"""The verdict on an experiment. Everything must be right; whatever is wrong is named with its number and its limit."""

from __future__ import annotations

import math
from typing import List, Sequence, Tuple

from yarm.commander.activity import Ending
from yarm.commander.events import TaskState
from yarm.commander.params import Removal
from yarm.experiments.run.cases import Case
from yarm.experiments.run.record import ContactTally, GoalRecord, PauseRecord, RobotRecord, RunInfo
from yarm.geometry.kinds import ContactKind, ObjectKind


def judge(
    info: RunInfo,
    case: Case,
    robots: Sequence[RobotRecord],
    goals: Sequence[GoalRecord],
    contacts: Sequence[ContactTally],
    pauses: Sequence[PauseRecord],
    arrival_limit_m: float,
    lost: int = 0,
) -> Tuple[str, ...]:
    """Everything that is wrong with a run, one sentence each; empty for a success.

    Of a run that was not recorded for a while the pauses and changed paths that a case demands are not.

    Args:
        info: what was run and how it ended.
        case: what must come out.
        robots: what each did.
        goals: what became of each.
        contacts: by ground truth.
        pauses: of the manipulators.
        arrival_limit_m: largest horizontal distance of an end effector from a goal it is said to have reached.
        lost: how often a hand lost a piece, by ground truth.
    """
    faults: List[str] = []
    given_up = case.may_fail and info.outcome == Ending.FAILED and any(refused(goal) for goal in goals)
    if info.outcome != Ending.SUCCEEDED and not given_up:
        faults.append(f"the Commander's mission ended {info.outcome or 'never'!r}: {info.reason or 'no reason given'}")
    if not goals:
        faults.append("no goal was ever seen by the Commander")
    for goal in goals:
        if not math.isfinite(goal.declared_s) and not (case.refusals and refused(goal)):
            faults.append(f"{goal.name} was not reached ({goal.status or 'no status'}): {goal.reason or 'no reason'}")
        elif math.isfinite(goal.declared_s) and not goal.reached and goes_to_bin(info, goal):
            faults.append(f"{goal.name} was declared done by {goal.robot or 'nobody'} and lies in no bin")
        elif math.isfinite(goal.declared_s) and not goal.reached:
            faults.append(
                f"{goal.name} was declared reached while {goal.robot or 'nobody'} stood {goal.distance_m:.2f} m away "
                f"(limit {arrival_limit_m:.2f} m)"
            )
    for tally in contacts:
        if tally.kind == ContactKind.FAILURE:
            faults.append(
                f"{tally.pair[0]} ({tally.links[0]}) touched {tally.pair[1]} ({tally.links[1]}) "
                f"at {tally.first_s:.1f} s, {1000 * tally.depth_m:.1f} mm deep"
            )
    if case.holds and lost:
        faults.append(f"hands lost a piece {lost} times on the way, none may be lost")
    return tuple(faults) if info.unrecorded_s else (*faults, *_missing(case, robots, pauses))


def _missing(case: Case, robots: Sequence[RobotRecord], pauses: Sequence[PauseRecord]) -> List[str]:
    """What a case demands beyond its goals and did not come out."""
    faults: List[str] = []
    if len(pauses) < case.min_pauses:
        faults.append(f"the manipulator paused {len(pauses)} times, {case.min_pauses} expected")
    replans = sum(robot.replans for robot in robots)
    if replans < case.min_replans:
        faults.append(f"paths changed {replans} times under way, {case.min_replans} expected")
    if case.everybody:
        idle = [robot.name for robot in robots if not robot.goals]
        faults += [f"{name} reached nothing: in this case every robot has something to reach" for name in idle]
    return faults


def goes_to_bin(info: RunInfo, goal: GoalRecord) -> bool:
    """Whether a goal must end in a bin."""
    return info.removal == Removal.BIN and goal.kind == ObjectKind.DEBRIS


def refused(goal: GoalRecord) -> bool:
    """The Commander gave the goal up and said why."""
    return (
        math.isnan(goal.declared_s) and goal.status in (TaskState.UNREACHABLE, TaskState.FAILED) and bool(goal.reason)
    )
