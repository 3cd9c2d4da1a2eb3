"""proof.html of a mission: what was seen, decided, driven and sanded, and why; one file, readable offline."""

from __future__ import annotations

import html
import math
from pathlib import Path
from typing import List, Optional, Sequence, Tuple

from yarm.commander.events import DecisionKind
from yarm.experiments.html import Rows, figure, folded, number, table, write_page
from yarm.experiments.run.ledger import ledger_hash, words
from yarm.experiments.run.record import GoalRecord, RunRecord, WaypointRow
from yarm.experiments.run.ways import part_svg, square_words, way_svg
from yarm.geometry import BoolArray, GridSpec


def write_proof(record: RunRecord, path: Path, spec: GridSpec, obstacles: Optional[BoolArray] = None) -> Path:
    """Write the proof sheet of a mission.

    Args:
        record: of the mission.
        path: of the HTML file.
        spec: the grid.
        obstacles: (gx, gy) columns with something that never moves, for the drawings; None when nobody knows.
    """
    info = record.info
    body = [_head(record)]
    body += [_goal(record, goal, spec, obstacles) for goal in record.goals]
    body += [_part(record, name) for name in dict.fromkeys(row.manipulator for row in record.squares)]
    body += [_section("Pauses of the manipulators", _pauses(record)), _section("Steps", _steps(record.waypoints))]
    listed = table(("number", "s", "decision"), _ledger(record), "decisions")
    body.append(_section("Decisions", folded(f"all {len(record.decisions)} decisions", listed)))
    return write_page(path, f"{info.case}, seed {info.seed}: proof of the mission", body)


def _section(title: str, content: str) -> str:
    return f"<section><h2>{html.escape(title)}</h2>{content}</section>"


def _head(record: RunRecord) -> str:
    info = record.info
    kind, verdict = ("right", "success") if record.success else ("wrong", "FAILED")
    faults = "".join(f"<li>{html.escape(fault)}</li>" for fault in record.faults)
    rows = [
        ("mission", f"{info.mode}, {info.outcome or 'never ended'} {info.reason}".rstrip()),
        ("length", f"{info.sim_s:.1f} s simulated"),
        ("the cell began anew", f"{info.begun_again} times (its simulation was started again)"),
        ("not recorded", f"{info.unrecorded_s:.1f} s (the recording process had died, or stood still)"),
        ("planning steps", f"{record.steps.planned}, {record.steps.refused} of them refused by the checker"),
        ("decisions", str(len(record.decisions))),
        ("hash of all decisions", ledger_hash(record.decisions)),
    ]
    return f"<h2 class='{kind}'>{verdict}</h2><ul>{faults}</ul>{table(('', ''), rows, 'mission')}"


def _goal(record: RunRecord, goal: GoalRecord, spec: GridSpec, obstacles: Optional[BoolArray]) -> str:
    """One piece of debris, or a target."""
    begin_s, end_s = _span(record, goal)
    bins = [way.goal for way in record.planned if way.robot == goal.robot and way.goal.endswith(f"/{goal.robot}")]
    wanted = {goal.name, *(bins if goal.bin else ())}
    mine = [row for row in record.waypoints if row.robot == goal.robot and row.goal in wanted]
    steps = [row for row in mine if begin_s <= row.time_s <= end_s]
    near = min(steps, key=lambda row: row.clearance_m if row.nearest else math.inf, default=None)
    least = "-" if near is None or not near.nearest else f"{near.clearance_m:.3f} m, to {near.nearest}"
    rows = [
        ("first seen", f"{number(goal.seen_s, 1, 's')}: {goal.cameras or 'never'}"),
        ("sent", f"{goal.robot or 'nobody'}{f': {goal.why}' if goal.why else ''}"),
        ("on the way", f"{number(begin_s, 1, 's')} to {number(end_s, 1, 's')}, {len(steps)} steps"),
        ("least clearance", least),
        ("removed", _removal(record, goal)),
    ]
    driven = [row for row in record.path if row.robot == goal.robot and begin_s <= row.time_s <= end_s]
    planned = [way.columns for way in record.planned if way.robot == goal.robot and way.goal in wanted]
    drawn = way_svg(spec, obstacles, planned, driven)
    caption = f"dashed: as first planned; line: as {goal.robot} drove, from the ring to the dot; grey: what never moves"
    told = [row for row in record.decisions if row.goal == goal.name and row.kind not in (DecisionKind.SEND,)]
    history = table(("s", "what"), [(f"{row.time_ms / 1e3:.2f}", words(row)) for row in told])
    kind = "right" if goal.reached else "wrong"
    title = f"<h2 class='{kind}'>{html.escape(f'{goal.kind} {goal.name}: {goal.status}')}</h2>"
    facts = table(("", ""), rows, f"goal-{goal.name}") + folded("what was decided about it", history)
    return f"<section>{title}<div class='row'>{figure(drawn, caption)}<div>{facts}</div></div></section>"


def _span(record: RunRecord, goal: GoalRecord) -> Tuple[float, float]:
    """From when to when its robot was on its way, s; until the end for one that was never reached."""
    given = [
        row.time_ms / 1e3
        for row in record.decisions
        if (row.kind, row.robot, row.goal) == (DecisionKind.ASSIGN, goal.robot, goal.name)
    ]
    end_s = goal.declared_s if math.isfinite(goal.declared_s) else record.info.sim_s
    return (given[-1] if given else math.nan), end_s


def _removal(record: RunRecord, goal: GoalRecord) -> str:
    if not math.isfinite(goal.declared_s):
        return f"not: {goal.reason or goal.status or 'no reason told'}"
    where = f", it lies in {goal.bin}" if goal.bin else ""
    asked = [row for row in record.decisions if row.kind == DecisionKind.DELETE and row.goal == goal.name]
    deletion = f", its deletion asked for at {asked[0].time_ms / 1e3:.1f} s" if asked else ""
    return f"reached at {goal.declared_s:.1f} s{where}{deletion}"


def _part(record: RunRecord, name: str) -> str:
    rows = [row for row in record.squares if row.manipulator == name]
    done = sum(math.isfinite(row.sanded_s) for row in rows)
    drawn = figure(part_svg(rows), "number: s at which the tool was first over the middle; x: never")
    told = [(f"{row.row}, {row.column}", square_words(row)) for row in rows]
    listed = folded(
        "every square: when, how fast, at what angle, or why not", table(("square", ""), told, f"part-{name}")
    )
    return _section(f"Part of {name}: {done} of {len(rows)} squares sanded", drawn + listed)


def _pauses(record: RunRecord) -> str:
    rows = [
        (
            pause.manipulator,
            number(pause.start_s, 1),
            number(pause.length_s, 1) if math.isfinite(pause.end_s) else "until the end",
            pause.cause or "not told",
        )
        for pause in record.pauses
    ]
    return table(("manipulator", "from s", "s long", "cause"), rows, "pauses") if rows else "<p>none</p>"


def _steps(waypoints: Sequence[WaypointRow]) -> str:
    rows: List[Tuple[str, ...]] = [
        (
            f"{row.time_s:.2f}",
            row.robot,
            row.goal or "makes way",
            f"({row.x_m:.3f}, {row.y_m:.3f}) m, {math.degrees(row.yaw_rad):.1f} deg",
            row.verdict or "not told",
            number(row.clearance_m, 3) + (f" to {row.nearest}" if row.nearest else ""),
        )
        for row in waypoints
    ]
    return table(("s", "robot", "goal", "to", "checker", "least clearance until the next, m"), rows, "steps")


def _ledger(record: RunRecord) -> Rows:
    return [(str(row.number), f"{row.time_ms / 1e3:.3f}", words(row)) for row in record.decisions]
