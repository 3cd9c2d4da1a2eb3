"""What the Commander reports, as messages."""

from __future__ import annotations

import math

import rospy

from yarm.commander.events import Decision, ShowPlan
from yarm.commander.machine import Status
from yarm.geometry import GridSpec
from yarm.msg import CommanderStatus, GridIndex, GridIndexVector, PlanReport, TaskStatus, WhyCause, WhyChange
from yarm.msg import Decision as DecisionMessage
from yarm.planning.why.causes import Answer, Cause
from yarm.ros.common import names
from yarm.srv import WhyResponse


def exact_time(stamp_s: float) -> rospy.Time:
    """The stamp a time in seconds was read from, to the nanosecond (``from_sec`` cuts off, and may lose one)."""
    return rospy.Time(0, max(0, round(stamp_s * 1e9)))


def status_message(status: Status, now_s: float) -> CommanderStatus:
    """CommanderStatus at a simulated time, s."""
    message = CommanderStatus(
        state=int(status.state),
        state_name=status.state.name,
        busy=status.busy,
        outcome=status.outcome.value,
        reason=status.reason,
        elapsed_s=status.elapsed_s,
    )
    message.header.stamp = exact_time(now_s)
    message.header.frame_id = names.WORLD_FRAME
    message.tasks = [
        TaskStatus(task.robot, task.goal, str(task.kind), task.status.value, task.reason, task.distance_left_m)
        for task in status.tasks
    ]
    return message


def plan_report(shown: ShowPlan, planner: str, stamp_s: float) -> PlanReport:
    """PlanReport of one planning step."""
    plan = shown.plan
    report = PlanReport(
        planner=planner,
        status=plan.status.value,
        reason=shown.refused or plan.reason,
        planning_ms=plan.planning_ms,
        check_ms=shown.check_ms,
        safe=not shown.refused,
        refusals=shown.refusals,
        iterations=plan.iterations,
        particles=len(plan.graph.particles),
        particles_needed=plan.particles,
    )
    report.header.stamp = exact_time(stamp_s)
    report.header.frame_id = names.WORLD_FRAME
    for name, robot_plan in sorted(plan.robots.items()):
        report.robots.append(name)
        report.goals.append(robot_plan.goal)
        report.statuses.append(robot_plan.status.value)
        report.robot_ms.append(robot_plan.planning_ms)
        report.length_cells.append(robot_plan.length_cells)
        report.moves.append(name in shown.sent)
        cells = [GridIndex(x=int(w.column[0]), y=int(w.column[1]), z=0) for w in robot_plan.path]
        report.paths.append(GridIndexVector(indices=cells))
    return report


def decision_message(decision: Decision, stamp_s: float) -> DecisionMessage:
    """Decision taken at a simulated time, s."""
    message = DecisionMessage(
        number=decision.number,
        kind=decision.kind.value,
        robot=decision.robot,
        goal=decision.goal,
        text=decision.text,
    )
    message.header.stamp = exact_time(stamp_s)
    message.header.frame_id = names.WORLD_FRAME
    return message


def why_response(answer: Answer, spec: GridSpec) -> WhyResponse:
    """The answer of ``commander/why``; how far things are moved in columns becomes metres."""
    return WhyResponse(success=True, text=answer.text, causes=[_why_cause(cause, spec) for cause in answer.causes])


def _why_cause(cause: Cause, spec: GridSpec) -> WhyCause:
    size_x, size_y = (float(size) for size in spec.resolution[:2])
    changes = [
        WhyChange(one.kind.value, one.thing, one.offset[0] * size_x, one.offset[1] * size_y, str(one))
        for one in cause.changes
    ]
    cells = [GridIndex(*map(int, cell)) for cell in cause.cells]
    return WhyCause(cause.kind, cause.text, cause.robot, list(cause.others), changes, cells, cause.cost_cells)


def task_text(task: TaskStatus) -> str:
    """One task in a line of progress: who goes for what, how it stands, how far it is (metres) when that is known."""
    left = "" if math.isnan(task.distance_left_m) else f" {task.distance_left_m:.2f} m"
    return f"{task.robot or 'nobody'} -> {task.goal} {task.status}{left}"
