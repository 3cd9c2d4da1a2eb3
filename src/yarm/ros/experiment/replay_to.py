"""``rosrun yarm replay_to``: brings the cell to a decision of a recorded mission again, and stops there.

    rosrun yarm replay_to --run results/2m1ma/3 --decision 41

The run must have been in lock-step (``run_experiment --sync``). Everything decided on the way is compared with what was
recorded; where it differs, the first difference is said. Exit code: 0 the cell stood at that decision again, 1 not.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import List, Sequence

import yaml

from yarm.experiments.run.ledger import LedgerError
from yarm.experiments.run.repeat import RESULT, decision_at, recorded_arguments
from yarm.ros.experiment.launcher import INTERRUPTED, MISSION_LIMIT_S, launch
from yarm.ros.experiment.page import page
from yarm.ros.experiment.ports import free_port

HOLD_LIMIT_S = 7 * 24 * 3600.0


def parser() -> argparse.ArgumentParser:
    """Options."""
    options = argparse.ArgumentParser(prog="replay_to", description="Bring the cell to a decision of a run again.")
    options.add_argument("--run", type=Path, required=True, help="folder of the results of a run in lock-step")
    options.add_argument("--decision", type=int, required=True, help="number of the decision, as in its proof.html")
    options.add_argument("--results", type=Path, help="folder for <case>/<seed>/; <run>/replay unless given")
    options.add_argument("--end", action="store_true", help="end there instead of standing still until Ctrl-C")
    options.add_argument("--console", action="store_true", help="show the cell in a browser")
    options.add_argument("--rviz", action="store_true", help="show it in RViz")
    options.add_argument("--port", type=int, default=0, help="port of its own ROS master; 0 takes a free one")
    return options


def main(argv: Sequence[str]) -> int:
    """Repeat, stop, and give the exit code."""
    options = parser().parse_args(argv)
    run = options.run.resolve()
    try:
        arguments, number = recorded_arguments(run), decision_at(run, options.decision)
    except LedgerError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    results = (options.results or run / "replay").resolve()
    results.mkdir(parents=True, exist_ok=True)
    for old in results.glob(f"*/*/{RESULT}"):
        old.unlink()
    port = options.port or free_port()
    with page(options.console, run.parents[1]) as shown:
        call = [*_call(port, arguments, run, number, options), f"results:={results}", *shown]
        sys.stdout.write(f"{run} up to decision {number}: ROS_MASTER_URI=http://localhost:{port}\n")
        sys.stdout.flush()
        limit_s = MISSION_LIMIT_S if options.end else HOLD_LIMIT_S
        code = launch(call, port, results / "replay.log", limit_s)
    found = sorted(results.glob(f"*/*/{RESULT}"))
    if not found:
        sys.stderr.write(f"it ended before decision {number}; see {results / 'replay.log'}\n")
        return code if code == INTERRUPTED else 1
    return 0 if yaml.safe_load(found[0].read_text())["reached"] else 1


def _call(port: int, arguments: Sequence[str], run: Path, number: int, options: argparse.Namespace) -> List[str]:
    """The roslaunch call: as recorded, as fast as it goes."""
    more = [f"replay:={run}", f"replay_decision:={number}", f"replay_hold:={str(not options.end).lower()}"]
    more += ["speed:=0", f"rviz:={str(options.rviz).lower()}"]
    return ["roslaunch", "-p", str(port), "yarm", "experiment.launch", *arguments, *more]
