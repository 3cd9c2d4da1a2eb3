"""The rows of ``bench/faults.py`` and the page that is made of them; needs no ROS."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any, Dict, List, Mapping, Sequence, Tuple

from yarm.experiments.run.tables import markdown_table

NODES = (
    "perception",
    "seed_tf_publisher",
    "commander",
    "multi_robot_controls_server",
    "hc10_state_machine",
    "safety_monitor",
    "simulation",
    "run_experiment",
    "roscore",
)
FAULTS, MOMENTS = ("kill", "stop", "stall"), ("calibration", "step", "pause", "cleanup")
Key = Tuple[str, str, str, int]
HEAD = """# Nodes that die or freeze in the midst of a mission
Written by `python3 bench/faults.py --report` from [its rows](data/faults.csv), whose columns its head explains.
Case `1m1ma` in physics and real time, with the way home. In a cell: missions that ended well of those that were run,
failure contacts by ground truth, and the longest simulated time from the fault to the node's next word. `kill`:
SIGKILL; `stop`: SIGSTOP for 5 s; `stall`: ten times SIGSTOP for 0.05 to 0.8 s, with as long between them. When the
simulation was killed the cell begins anew, and its time with it: the time given is of the new cell, and so is the
mission. `run_experiment` is who records and asks. With the ROS master (`roscore`, under `keep_running`) everything is
started again, and the mission with it; contacts of both are counted. One run of the simulation and six of
`run_experiment` were not as wanted at first: their causes were mended, and they were run again. The machine was shared
with much other work: simulated time is what counts, a second of it took one to five of the wall.
"""


def key_of(row: Mapping[str, Any]) -> Key:
    """What identifies a row."""
    return row["node"], row["fault"], row["moment"], int(row["seed"])


def known_rows(path: Path) -> List[Dict[str, Any]]:
    """Rows of the runs that were made."""
    if not path.is_file():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def page(rows: Sequence[Mapping[str, Any]]) -> str:
    """The table: a row a node and fault, a column a moment."""
    cells: List[List[str]] = []
    for node in NODES:
        for fault in FAULTS:
            own = [row for row in rows if (row["node"], row["fault"]) == (node, fault)]
            cells.append([f"`{node}`", fault, *(_cell([r for r in own if r["moment"] == m]) for m in MOMENTS)])
    return markdown_table(("node", "fault", *MOMENTS), cells)


def written(rows: Sequence[Mapping[str, Any]]) -> str:
    """The page ``bench/faults.md``."""
    bad = [row for row in rows if str(row["success"]) != "True" or str(row["contacts"]) != "0"]
    told = [f"- {' '.join(map(str, key_of(row)))}: {row['contacts']} contacts; {row['said']}" for row in bad]
    return "\n".join(
        [HEAD, page(rows), "", *(["Not as wanted:", *told] if told else ["Every one of them as wanted."]), ""]
    )


def _cell(rows: Sequence[Mapping[str, Any]]) -> str:
    """Missions that ended well of all, contacts, slowest way back."""
    if not rows:
        return "not run"
    good = sum(str(row["success"]) == "True" for row in rows)
    contacts = sum(int(row["contacts"] or 0) for row in rows)
    times = [float(row["back_s"]) for row in rows if row["back_s"] not in ("", "nan")]
    back = f", back after {max(times):.1f} s" if times else ""
    return f"{good}/{len(rows)}, {contacts} contacts{back}"
