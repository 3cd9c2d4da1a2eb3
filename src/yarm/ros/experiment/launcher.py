"""Runs ``experiment.launch`` as a child and gives back its verdict, which roslaunch itself does not."""

from __future__ import annotations

import argparse
import math
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Dict, List, Sequence, Tuple

import psutil
import yaml

from yarm.commander.params import CommanderParams, Execution, Removal
from yarm.experiments.cells.outcome import cell_line, kind_of, read_cell
from yarm.experiments.run.cases import case_of
from yarm.experiments.run.repeat import write_arguments
from yarm.experiments.run.writers import explore_folder, inspect_folder
from yarm.planning.model.hidden import HiddenPolicy
from yarm.planning.model.params import PlannerParams
from yarm.robots.hc10 import NAME
from yarm.robots.turns import FINER_TURNS_DEG, QUARTER_TURNS_DEG
from yarm.ros.common.launch_arguments import CHECKS, faults
from yarm.ros.common.priority import lower
from yarm.ros.experiment.console import Console, last_words
from yarm.ros.experiment.page import look_back, page
from yarm.ros.experiment.ports import free_port
from yarm.sim.checks.cell_check import unreachable_goals
from yarm.sim.scenes.random_cell import KINDS, random_cell
from yarm.sim.scenes.scene import Scene, SceneError, load_scene
from yarm.sim.scenes.scene_file import scene_text

EXPLORE, INSPECT, RANDOM = "explore", "inspect", "random"
MISSION_LIMIT_S = 900.0
SLOWEST = 4.0
"""Wall seconds that a simulated second of a soak may take."""
HALF_TURN_DEG = 180.0
STOP_LIMIT_S = 40.0
INTERRUPTED = 130
POLL_S = 0.25
PUBLISHED = "original"
"""The published planner; with it what no camera sees is free, as published."""
FREE, KNOWN_BODIES = HiddenPolicy.FREE.value, HiddenPolicy.KNOWN_BODIES.value
STRAY_SIZE_M = 0.25
"""Longest edge of what counts as debris where a scene has some that nobody registers; shipped debris has 0.15 m."""


def parser() -> argparse.ArgumentParser:
    """Options of ``rosrun yarm run_experiment``."""
    options = argparse.ArgumentParser(
        prog="run_experiment", description="Run one experiment end to end and say whether it succeeded (exit code 0)."
    )
    options.add_argument(
        "--case",
        default="1m1ma",
        help="1m1ma and 2m1ma (with hands and a bin, 1m1ma_bin and 2m1ma_bin; as published with --removal delete), "
        "3m6_bin, 2m2ma, 3m, single, 1m1ma_target, explore, inspect, random or a scene file",
    )
    options.add_argument("--kind", choices=KINDS, help="random: kind of the cell; all in turn by the seed unless given")
    options.add_argument("--arena", default="practice", help="explore: shipped arena, or an arena file")
    options.add_argument("--layout", default="practice", help="inspect: practice, a made one such as open_0, or a file")
    options.add_argument(
        "--controller",
        default="yarm",
        help="explore: yarm, nearest, explore_lite, report, ...; inspect: yarm, report, ...",
    )
    options.add_argument("--seed", type=int, default=3, help="seed of the layout, the noise and the planner")
    options.add_argument("--nominal", action="store_true", help="the layout of the scene file whatever the seed")
    options.add_argument("--mode", choices=("bounded", "boundless"), default="boundless")
    _add_planning(options)
    options.add_argument("--planned-once", action="store_true", help="no re-planning: follow the first path to its end")
    options.add_argument(
        "--unguarded", action="store_true", help="no safety monitor, and the checker only counts, as published"
    )
    options.add_argument("--hands", action="store_true", help="the robots carry a hand; always so in a cell with a bin")
    options.add_argument(
        "--removal",
        choices=[way.value for way in Removal],
        help="debris that was reached is gone (delete, as published), or carried to a bin (bin); unless given bin, "
        "where there is one",
    )
    options.add_argument("--rviz", action="store_true", help="show it")
    options.add_argument("--console", action="store_true", help="show it in a browser, and command the cell there")
    options.add_argument("--sync", action="store_true", help="lock-step: slower, repeats exactly")
    options.add_argument("--bag", action="store_true", help="record a bag beside the results")
    options.add_argument("--cleanup", action="store_true", help="send everybody home at the end")
    options.add_argument("--results", default="results", help="folder for <case>/<seed>/")
    options.add_argument(
        "--speed",
        type=float,
        default=None,
        help="greatest speed of the simulation; 0: no limit; 1 when not given, and for explore and inspect lock-step "
        "without limit",
    )
    options.add_argument("--raster", type=float, default=0.0, help="begin when so much of the raster is done, 0 to 1")
    options.add_argument("--soak", type=float, default=0.0, help="simulated seconds to go on with random debris")
    _add_limits(options)
    return options


def _add_limits(options: argparse.ArgumentParser) -> None:
    """What it may take of time and of the machine."""
    options.add_argument(
        "--limit", type=float, default=0.0, help="simulated seconds for the mission; 0: the case's own"
    )
    options.add_argument(
        "--wall-limit", type=float, default=0.0, help="s of wall time until it is stopped; 0: 900 and four times --soak"
    )
    options.add_argument("--port", type=int, default=0, help="port of its own ROS master; 0 takes a free one")
    options.add_argument(
        "--nice",
        type=int,
        choices=range(20),
        default=0,
        metavar="0..19",
        help="scheduling priority of all it starts, 19 the last; 0: as usual",
    )


def _add_planning(options: argparse.ArgumentParser) -> None:
    """How is planned, and how a plan is carried out."""
    options.add_argument(
        "--planner", default="yarm", help="yarm, original, ma_astar, lacam, ompl_..., or your own module:Class"
    )
    options.add_argument("--particles", type=int, default=PlannerParams.particles, help="particles of a search at most")
    options.add_argument(
        "--turns",
        type=angles,
        default=(),
        metavar="DEG,DEG,...",
        help="turns about the end effector that the planner may use; unless given quarter turns, "
        "and eighths where debris is carried to a bin",
    )
    options.add_argument(
        "--execution",
        choices=[way.value for way in Execution],
        default=CommanderParams.execution,
        help="everybody waits until all have arrived (steps), or goes on when its next move is free (continuous)",
    )
    options.add_argument(
        "--sand-elsewhere",
        action="store_true",
        help="manipulators are told where debris and robots are, or will be, and sand elsewhere meanwhile",
    )
    options.add_argument(
        "--hidden",
        choices=[policy.value for policy in HiddenPolicy],
        help="what cells that no camera sees count as (docs/planning.md); "
        f"unless given {KNOWN_BODIES}, {FREE} with the published planner, {PUBLISHED}",
    )
    options.add_argument(
        "--debris-size",
        type=float,
        metavar="M",
        help="longest edge of debris that nobody registered and perception is to find, m; 0: none; "
        f"unless given {STRAY_SIZE_M:g} where the scene has such debris (docs/perception.md)",
    )


def run(arguments: Sequence[str]) -> int:
    """Launch, wait, and give back 0 on success, 1 on failure, 130 when interrupted."""
    options = parser().parse_args(arguments)
    with page(options.console, Path(options.results)) as shown:
        code = run_case(options, shown)
    if code != INTERRUPTED:
        look_back(folder_of(options), shown)
    return code


def run_case(options: argparse.Namespace, more: Sequence[str]) -> int:
    """Launch with more arguments, wait, and give back the exit code of ``run``."""
    options.case = case_to_run(options)
    cell = prepare_cell(options) if options.case == RANDOM else None
    port = options.port or free_port()
    call = {EXPLORE: exploration_command, INSPECT: inspection_command}.get(options.case, command)(options, port)
    call += more
    words = [word for word in call if word.partition(":=")[0] in CHECKS]
    if options.case == INSPECT:
        words = [word.replace("controller:=", "controller@inspection:=", 1) for word in words]
    wrong = faults(words)
    if wrong:
        sys.stderr.write("".join(f"{fault}\n" for fault in wrong))
        return 1
    folder = folder_of(options)
    summary = folder / "summary.yaml"
    folder.mkdir(parents=True, exist_ok=True)
    if summary.exists():
        summary.unlink()
    if options.case not in (EXPLORE, INSPECT):
        write_arguments(folder, call)
    log = folder / "run.log"
    roomed = options.case in (EXPLORE, INSPECT)
    title = f"{options.case} {folder.parents[1].name}, {options.controller}" if roomed else folder.parent.name
    sys.stdout.write(f"{title}, seed {options.seed}: ROS_MASTER_URI=http://localhost:{port}, log {log}\n")
    sys.stdout.flush()
    code = launch(call, port, log, wall_limit_s(options), options.nice)
    if code == INTERRUPTED:
        return code
    code = verdict(summary) if cell is None else cell_verdict(cell, folder, options.turns)
    if code != 0:
        sys.stderr.write(f"the last of {log}:\n" + "".join(f"  {line}\n" for line in last_words(log)))
        sys.stderr.write("".join(f"wrong: {fault}\n" for fault in faults_of(summary)))
    sys.stdout.write(f"log: {log}\n")
    return code


def launch(call: Sequence[str], port: int, log: Path, limit_s: float, nice: int = 0) -> int:
    """Run a roslaunch call on a master of its own to its end, or for so long, s; INTERRUPTED when a person ends it.

    With a ``nice`` above 0 everything it starts is kept at that scheduling priority.
    """
    child = subprocess.Popen(
        list(call),
        env=dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}"),
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert child.stdout is not None
    console = Console(child.stdout, log)
    code = _wait(child, limit_s, nice)
    console.finish()
    return code


def case_to_run(options: argparse.Namespace) -> str:
    """The case that is asked for, or the one with a bin that is run in its place; a soak's debris is deleted."""
    deleted = options.removal == Removal.DELETE.value or options.soak > 0.0
    return options.case if deleted else case_of(options.case).with_bin or options.case


def folder_of(options: argparse.Namespace) -> Path:
    """Folder of the results of these options."""
    results = Path(options.results).resolve()
    if options.case == EXPLORE:
        return explore_folder(results, options.arena, options.controller, options.seed)
    if options.case == INSPECT:
        return inspect_folder(results, options.layout, options.controller, options.seed)
    return results / ("soak" if options.soak > 0.0 else Path(options.case).stem) / str(options.seed)


def prepare_cell(options: argparse.Namespace) -> Scene:
    """Draw the random cell that is asked for, write it beside its results and make it the case, laid out as it is."""
    cell = random_cell(options.kind or kind_of(options.seed), options.seed)
    options.case, options.nominal = f"{cell.name}.yaml", True
    folder = folder_of(options)
    folder.mkdir(parents=True, exist_ok=True)
    options.case = str(folder / options.case)
    Path(options.case).write_text(scene_text(cell))
    return load_scene(options.case)


def cell_verdict(cell: Scene, folder: Path, turns_deg: Sequence[float] = ()) -> int:
    """0 when every goal that can be reached was, every other one was refused, and nothing was touched.

    ``turns_deg`` are the turns that were asked for; empty for the usual ones.
    """
    turns_deg = (*(turns_deg or QUARTER_TURNS_DEG), *FINER_TURNS_DEG)
    result = read_cell(cell, folder, unreachable_goals(cell, turns_deg))
    sys.stdout.write(f"{cell_line(result)}\n")
    return 0 if result.success else 1


def exploration_command(options: argparse.Namespace, port: int) -> List[str]:
    """The roslaunch call for an exploration: in lock-step and as fast as it goes, unless a speed is asked for."""
    return _room_command(options, port, "explore_experiment.launch", "arena", options.arena)


def inspection_command(options: argparse.Namespace, port: int) -> List[str]:
    """The same for an inspection."""
    return _room_command(options, port, "inspect_experiment.launch", "layout", options.layout)


def _room_command(options: argparse.Namespace, port: int, launch: str, what: str, source: str) -> List[str]:
    """The roslaunch call for one robot in a room: an arena or a layout, by name or file."""
    values = {
        what: Path(source).resolve() if source.endswith(".yaml") else source,
        "controller": options.controller,
        "seed": options.seed,
        "folder": folder_of(options),
        "real_time_factor": options.speed or 0.0,
        "sync": str(options.sync or options.speed is None).lower(),
        "rviz": str(options.rviz).lower(),
        "bag": str(options.bag).lower(),
    }
    if options.limit > 0.0:
        values["time_limit_s"] = options.limit
    arguments = [f"{name}:={value}" for name, value in values.items()]
    return ["roslaunch", "-p", str(port), "yarm", launch, *arguments]


def command(options: argparse.Namespace, port: int) -> List[str]:
    """The roslaunch call for an experiment in the cell."""
    values = {
        "case": options.case,
        "seed": options.seed,
        "mode": options.mode,
        "planner": options.planner,
        "particles": options.particles,
        "execution": options.execution,
        "hidden": options.hidden or (FREE if options.planner == PUBLISHED else KNOWN_BODIES),
        "debris_size": debris_size(options),
        "speed": 1.0 if options.speed is None else options.speed,
        "raster": options.raster,
        "limit_s": options.limit,
        "soak_s": options.soak,
        "results": Path(options.results).resolve(),
    }
    flags = {name: getattr(options, name) for name in ("rviz", "sync", "bag", "cleanup")}
    arms = working_arms(options.case)
    flags["sander"] = bool(arms)
    values["arms"] = " ".join(arms) or NAME
    flags["guarded"] = not options.unguarded
    flags["vary"] = not options.nominal
    flags["replanning"] = not options.planned_once
    flags["sand_elsewhere"] = options.sand_elsewhere
    bins = has_bins(options.case)
    flags["hands"] = options.hands or bins
    values["removal"] = options.removal or (Removal.BIN if bins else Removal.DELETE).value
    values["turns_deg"] = list(options.turns or turns_for(Removal(values["removal"])))
    arguments = [f"{name}:={value}" for name, value in values.items()]
    arguments += [f"{name}:={str(value).lower()}" for name, value in flags.items()]
    return ["roslaunch", "-p", str(port), "yarm", "experiment.launch", *arguments]


def angles(text: str) -> Tuple[float, ...]:
    """Degrees separated by commas, as an option's type.

    Raises:
        argparse.ArgumentTypeError: something else, or an angle beyond half a turn.
    """
    try:
        found = tuple(float(word) for word in text.split(","))
    except ValueError:
        found = (math.nan,)
    if not all(abs(angle) <= HALF_TURN_DEG for angle in found):
        raise argparse.ArgumentTypeError(f"{text!r}: angles within -180 to 180 deg, separated by commas, are expected")
    return found


def turns_for(removal: Removal) -> Tuple[float, ...]:
    """Turns that robots make, degrees; to a bin finer ones too, because body, arm and bin leave few headings."""
    return (*PlannerParams.turns_deg, *(FINER_TURNS_DEG if removal is Removal.BIN else ()))


def wall_limit_s(options: argparse.Namespace) -> float:
    """Wall time the whole may take, s."""
    return float(options.wall_limit or MISSION_LIMIT_S + SLOWEST * options.soak)


def working_arms(case: str) -> Tuple[str, ...]:
    """Manipulators that work in a scene; a scene that cannot be read is left to the simulation to refuse."""
    try:
        return load_scene(case).working_arms
    except SceneError:
        return (NAME,)


def debris_size(options: argparse.Namespace) -> float:
    """Longest edge of debris that perception is to find, m; a scene that cannot be read is left to the simulation."""
    if options.debris_size is not None:
        return float(options.debris_size)
    try:
        return STRAY_SIZE_M if load_scene(options.case).has_stray_debris else 0.0
    except SceneError:
        return 0.0


def has_bins(case: str) -> bool:
    """Whether a scene has bins; one that cannot be read is left to the simulation to refuse."""
    try:
        return bool(load_scene(case).bins)
    except SceneError:
        return False


def verdict(summary: Path) -> int:
    """0 when the results say success."""
    if not summary.is_file():
        sys.stderr.write(f"the experiment ended without results: {summary} was not written; see the output above\n")
        return 1
    return 0 if yaml.safe_load(summary.read_text()).get("success") is True else 1


def faults_of(summary: Path) -> List[str]:
    """What the results say is wrong, a sentence each; nothing where there are no results."""
    return list(yaml.safe_load(summary.read_text()).get("faults", ())) if summary.is_file() else []


class Family:
    """The child and everything it has started, remembered while it lives: orphans are found too."""

    def __init__(self, child: subprocess.Popen[bytes]) -> None:
        """Nobody but the child yet."""
        self._child = child
        self._known: Dict[int, psutil.Process] = {}

    def look(self) -> None:
        """Remember who has been started."""
        try:
            for process in psutil.Process(self._child.pid).children(recursive=True):
                self._known.setdefault(process.pid, process)
        except psutil.NoSuchProcess:
            return

    def lower(self, nice: int) -> None:
        """Keep all of them at this scheduling priority, their sessions too, whatever they have asked for."""
        for pid in (self._child.pid, *self._known):
            with suppress(OSError):  # it has ended since
                lower(pid, nice)

    def stop(self) -> None:
        """End the child, gently first, and whoever it has left behind."""
        self.look()
        if self._child.poll() is None:
            self._child.send_signal(signal.SIGINT)
        deadline = time.monotonic() + STOP_LIMIT_S
        while self._child.poll() is None and time.monotonic() < deadline:
            self.look()
            time.sleep(POLL_S)
        _, alive = psutil.wait_procs(list(self._known.values()), timeout=1.0)
        for process in alive:
            with suppress(psutil.NoSuchProcess):  # it has ended since, and its number may be somebody else's
                process.terminate()
        _, alive = psutil.wait_procs(alive, timeout=3.0)
        for process in alive:
            with suppress(psutil.NoSuchProcess):
                process.kill()
        if self._child.poll() is None:
            self._child.kill()
            self._child.wait()


def _wait(child: subprocess.Popen[bytes], limit_s: float, nice: int) -> int:
    family = Family(child)
    deadline = time.monotonic() + limit_s
    try:
        while child.poll() is None and time.monotonic() < deadline:
            family.look()
            if nice > 0:
                family.lower(nice)
            time.sleep(POLL_S)
    except KeyboardInterrupt:
        family.stop()
        return INTERRUPTED
    if child.poll() is None:
        sys.stderr.write(f"stopped after {limit_s:.0f} s of wall time (--wall-limit)\n")
    family.stop()
    return 0
