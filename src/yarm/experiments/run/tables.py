"""Text tables for terminals and Markdown pages."""

from __future__ import annotations

import math
from typing import List, Sequence

from yarm.experiments.run.record import NodeUsage, RunRecord
from yarm.geometry.kinds import ContactKind


def text_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns aligned by spaces, with a rule under the header."""
    lines = [list(header), *(list(row) for row in rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(header))]
    text = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in lines]
    return "\n".join([text[0], "  ".join("-" * width for width in widths), *text[1:]])


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """The same as a Markdown table."""
    lines = [list(header), ["---"] * len(header), *(list(row) for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def summary_table(record: RunRecord) -> str:
    """What a person wants to know at the end of an experiment."""
    info = record.info
    parts: List[str] = [
        f"{info.case}, seed {info.seed}, {info.mode}: {'SUCCESS' if record.success else 'FAILED'}; "
        f"{info.sim_s:.1f} s simulated in {info.wall_s:.1f} s (real-time factor {_number(info.real_time_factor, 2)})"
    ]
    parts += [f"  wrong: {fault}" for fault in record.faults]
    if info.begun_again:
        parts.append(f"  the cell began anew {info.begun_again} times: its simulation was started again")
    if info.unrecorded_s:
        parts.append(f"  {info.unrecorded_s:.1f} s were not recorded: the recording process had died, or stood still")
    header = ("robot", "reached", "at s", "waypoints", "path m", "replans", "plan p50/p99 ms", "clearance m", "nearest")
    rows = [
        (
            r.name,
            _some(r.goals) or ("-" if r.reached else "nothing"),
            _number(r.time_s, 1),
            str(r.waypoints),
            f"{r.path_m:.2f}",
            str(r.replans),
            f"{_number(r.planning_p50_ms, 1)}/{_number(r.planning_p99_ms, 1)}",
            _number(r.min_clearance_m, 3),
            r.nearest or "-",
        )
        for r in record.robots
    ]
    parts += ["", text_table(header, rows)]
    parts += ["", _pauses_line(record), _contacts_line(record)]
    if record.steps.refused:
        parts.append(f"checker: {record.steps.refused} of {record.steps.planned} planning steps refused")
    if record.usage:
        parts += ["", usage_table(record.usage)]
    return "\n".join(parts)


def usage_table(nodes: Sequence[NodeUsage], frame: str = "frame") -> str:
    """Processor time and memory of each node.

    Args:
        nodes: what each cost.
        frame: what its processor time is divided by.
    """
    header = ("node", "share of a core", f"ms a {frame}", "MB start", "half-way", "end")
    rows = [
        (
            u.node,
            f"{100 * u.cpu_share:.0f} %",
            _number(u.ms_per_frame, 1),
            f"{u.memory_start_mb:.0f}",
            _number(u.memory_middle_mb, 0),
            f"{u.memory_end_mb:.0f}",
        )
        for u in nodes
    ]
    return text_table(header, rows)


def _pauses_line(record: RunRecord) -> str:
    spans = [f"{p.manipulator} {p.start_s:.1f}-{_number(p.end_s, 1)} s" for p in record.pauses]
    return f"manipulator pauses: {len(spans)}" + (f" ({_some(spans)})" if spans else "")


def _contacts_line(record: RunRecord) -> str:
    failures = [t for t in record.contacts if t.kind == ContactKind.FAILURE]
    others = [t for t in record.contacts if t.kind != ContactKind.FAILURE]
    pairs = _some([f"{t.pair[0]}-{t.pair[1]}" for t in others], 10)
    return f"contacts: {len(failures)} failures; {len(others)} that may be" + (f" ({pairs})" if pairs else "")


def _some(words: Sequence[str], most: int = 3) -> str:
    """The first few words, and how many more there are."""
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return ", ".join(words[:most]) + more


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"
