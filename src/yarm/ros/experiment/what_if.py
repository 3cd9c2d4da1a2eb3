"""``rosrun yarm what_if``: what would come of the cell under alternatives, from many runs on the kinematic world.

    rosrun yarm what_if --robots 1..3                                  the live cell, as it is and with 1 to 3 robots
    rosrun yarm what_if --case 2m1ma_bin --planner yarm,lacam --runs 20
    rosrun yarm what_if --run results/2m1ma/3 --at 12.5 --set execution=continuous

The cell as it is always stands beside the alternatives; every combination of what is asked for is one. Exit code: 0
answered, 1 the question is wrong, 2 no live cell answers.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import json
import os
import sys
from concurrent.futures import Executor
from pathlib import Path
from typing import Dict, List, Optional, Sequence

from yarm.experiments.study.arm_track import raster_track
from yarm.experiments.study.processes import copies
from yarm.experiments.study.runner import StudyError
from yarm.experiments.what_if.answer import answers, table
from yarm.experiments.what_if.ask import (
    ANY_CELL,
    Alternative,
    alternative,
    ask,
    check_question,
    combined,
    robot_numbers,
    specs_of,
)
from yarm.experiments.what_if.cell import Cell, NoCellError, WhatIfError, cell_of_case, cell_of_run
from yarm.experiments.what_if.physics import check_physics, physics, runs_at_once
from yarm.experiments.what_if.trial import ROBOTS, WhatIfResult, WhatIfSpec, kinematic
from yarm.records import RecordError, plain, read
from yarm.ros.common.priority import in_own_session

NICE = 19
ANSWERED, WRONG, NO_CELL = 0, 1, 2


def parser() -> argparse.ArgumentParser:
    """Options."""
    options = argparse.ArgumentParser(prog="what_if", description="What would come of the cell under alternatives.")
    source = options.add_mutually_exclusive_group()
    source.add_argument("--case", help="a shipped scene or a scene file; unless given the live cell")
    source.add_argument("--run", type=Path, help="folder of a recorded run's results; the moment by --at")
    source.add_argument("--cell", type=Path, help=argparse.SUPPRESS)
    options.add_argument("--at", type=float, default=0.0, help="with --run: s since its mission began")
    options.add_argument("--robots", default="", help="numbers of robots: 2, or 1,3, or 1..4")
    options.add_argument("--planner", default="", help="planners, separated by commas")
    options.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE[,VALUE...]",
        help="a parameter of the Commander (docs/parameters.md), and its values",
    )
    options.add_argument("--alternative", action="append", default=[], help="one alternative: 'KEY=VALUE KEY=VALUE'")
    options.add_argument("--runs", type=int, default=10, help="runs of each alternative")
    options.add_argument("--seed", type=int, default=1, help="of the first run; the others follow it")
    options.add_argument("--mode", choices=("bounded", "boundless"), default="boundless")
    options.add_argument("--limit", type=float, default=300.0, help="simulated seconds a mission may take")
    options.add_argument(
        "--physics", action="store_true", help="full physics in lock-step; half a minute to minutes a run"
    )
    options.add_argument("--scheduler", default="", help="address of a Dask scheduler; unless given local processes")
    options.add_argument(
        "--workers", type=int, default=0, help="runs at a time; 0: one a core, with --physics one for two cores"
    )
    options.add_argument("--results", type=Path, default=Path("results"), help="folder for what_if/")
    options.add_argument("--answers", type=Path, help=argparse.SUPPRESS)
    return options


def main(argv: Sequence[str]) -> int:
    """Ask, print, draw, and give the exit code."""
    options = parser().parse_args(argv)
    return in_own_session(NICE, lambda: _answer(options))


def _answer(options: argparse.Namespace) -> int:
    try:
        alternatives = _alternatives(options)
        specs = _checked(options, alternatives)  # before there are copies: what is wrong is said at once
        with contextlib.ExitStack() as stack:
            pool = _pool(options, stack)
            specs = specs or _specs(options, alternatives)
            _say(f"{specs[0].cell.source}: {len(alternatives)} alternatives, {options.runs} runs each")
            results = ask(specs, physics() if options.physics else kinematic(), _say, options.scheduler, pool)
    except (WhatIfError, StudyError) as error:
        sys.stderr.write(f"what_if: {error}\n")
        return WRONG
    except NoCellError as error:
        sys.stderr.write(f"what_if: {error}\n")
        return NO_CELL
    _keep(options, [name for name, _ in alternatives], results)
    return ANSWERED


def _pool(options: argparse.Namespace, stack: contextlib.ExitStack) -> Optional[Executor]:
    """What runs beside this process; None for nothing.

    A run in physics is a process of its own that keeps two cores busy. What the other forks share is reckoned before
    there are any.
    """
    cores = os.cpu_count() or 1
    if options.scheduler:
        return None
    if options.physics:
        return stack.enter_context(runs_at_once(options.workers or max(1, cores // 2)))
    if (options.workers or cores) == 1:
        return None
    raster_track()
    return stack.enter_context(copies(options.workers or cores))


def _checked(options: argparse.Namespace, alternatives: Sequence[Alternative]) -> List[WhatIfSpec]:
    """What is to be run; nothing yet of a live cell, which is asked for by ROS and so after the copies are made.

    Raises:
        WhatIfError: it cannot be asked.
    """
    if (options.case, options.run, options.cell) != (None, None, None):
        return _specs(options, alternatives)
    check_question(ANY_CELL, alternatives, options.runs, options.physics)
    return []


def _specs(options: argparse.Namespace, alternatives: Sequence[Alternative]) -> List[WhatIfSpec]:
    """What is to be run.

    Raises:
        WhatIfError: it cannot be asked.
        NoCellError: no live cell answers.
    """
    cell = _cell(options)
    more = {"bounded": options.mode == "bounded", "limit_s": options.limit}
    specs = specs_of(cell, alternatives, options.runs, options.seed, more, options.physics)
    if options.physics:
        check_physics(specs)
    return specs


def _keep(options: argparse.Namespace, names: Sequence[str], results: Sequence[WhatIfResult]) -> None:
    """The answers as words and a picture, which are said, or written for who called."""
    found = answers(results, names)
    plot = importlib.import_module("yarm.experiments.what_if.picture").plot  # loading it takes half as long as a run
    source, folder = results[0].spec.cell.source, options.results.resolve() / "what_if"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "answer.txt").write_text(f"{source}\n{table(found)}\n")
    picture = str(plot(results, names, folder / "answer.png", source))
    if options.answers is None:
        _say(f"drawn: {picture}")
        return
    values = {"table": table(found), "answers": [plain(one) for one in found], "plot": picture}
    options.answers.write_text(json.dumps(values))


def _alternatives(options: argparse.Namespace) -> List[Alternative]:
    choices: Dict[str, List[str]] = {}
    if options.robots:
        choices[ROBOTS] = robot_numbers(options.robots)
    if options.planner:
        choices["planner"] = options.planner.split(",")
    for word in options.set:
        name, separator, values = word.partition("=")
        if not separator or not name or not values:
            raise WhatIfError(f"--set {word!r}: must be KEY=VALUE or KEY=VALUE,VALUE")
        choices[name] = [values] if values.startswith("[") else values.split(",")
    if options.alternative and choices:
        raise WhatIfError("--alternative says all of it: leave out --robots, --planner and --set, or it")
    return [alternative(text) for text in options.alternative] if options.alternative else combined(choices)


def _cell(options: argparse.Namespace) -> Cell:
    """What is to be forked.

    Raises:
        WhatIfError: it cannot be.
        NoCellError: no live cell answers.
    """
    if options.case is not None:
        return cell_of_case(options.case, in_physics=options.physics)
    if options.run is not None:
        return cell_of_run(options.run, options.at)
    if options.cell is not None:
        try:
            return read(Cell, json.loads(options.cell.read_text()))
        except (OSError, ValueError, RecordError) as error:
            raise WhatIfError(f"{options.cell}: no cell: {error}") from error
    return _cell_of_ros()


def _cell_of_ros() -> Cell:
    """The live cell, read by a copy of this process that ends with it: its node would go on hearing /clock."""
    with copies(1) as reader:
        return reader.submit(_read_live).result()


def _read_live() -> Cell:
    live: Cell = importlib.import_module("yarm.ros.experiment.live_cell").live_cell()  # only this needs messages
    return live


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()
