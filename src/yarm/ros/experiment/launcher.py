"""Runs ``experiment.launch`` as a child and gives back its verdict, which roslaunch itself does not."""

from __future__ import annotations

import argparse
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Dict, List, Sequence

import psutil
import yaml

from yarm.sim.scene import SceneError, load_scene

MISSION_LIMIT_S = 900.0
SLOWEST = 4.0
"""Wall seconds that a simulated second of a soak may take."""
STOP_LIMIT_S = 40.0
INTERRUPTED = 130
POLL_S = 0.25


def parser() -> argparse.ArgumentParser:
    """Options of ``rosrun yarm run_experiment``."""
    options = argparse.ArgumentParser(
        prog="run_experiment", description="Run one experiment end to end and say whether it succeeded (exit code 0)."
    )
    options.add_argument("--case", default="1m1ma", help="1m1ma, 2m1ma, 3m, single, 1m1ma_target or a scene file")
    options.add_argument("--seed", type=int, default=3, help="seed of the scene and the planner")
    options.add_argument("--mode", choices=("bounded", "boundless"), default="boundless")
    options.add_argument("--planner", default="yarm", help="yarm, original, ma_astar, ompl_...")
    options.add_argument("--particles", type=int, default=333, help="particles of the planner, at least")
    options.add_argument("--unguarded", action="store_true", help="no checker, no safety monitor, as published")
    options.add_argument("--rviz", action="store_true", help="show it")
    options.add_argument("--sync", action="store_true", help="lock-step: slower, repeats exactly")
    options.add_argument("--bag", action="store_true", help="record a bag beside the results")
    options.add_argument("--cleanup", action="store_true", help="send everybody home at the end")
    options.add_argument("--results", default="results", help="folder for <case>/<seed>/")
    options.add_argument("--speed", type=float, default=1.0, help="greatest speed of the simulation; 0: no limit")
    options.add_argument("--raster", type=float, default=0.0, help="begin when so much of the raster is done, 0 to 1")
    options.add_argument("--soak", type=float, default=0.0, help="simulated seconds to go on with random debris")
    options.add_argument(
        "--limit", type=float, default=0.0, help="simulated seconds for the mission; 0: the case's own"
    )
    options.add_argument(
        "--wall-limit", type=float, default=0.0, help="s of wall time until it is stopped; 0: 900 and four times --soak"
    )
    options.add_argument("--port", type=int, default=0, help="port of its own ROS master; 0 takes a free one")
    return options


def run(arguments: Sequence[str]) -> int:
    """Launch, wait, and give back 0 on success, 1 on failure, 130 when interrupted."""
    options = parser().parse_args(arguments)
    folder = (
        Path(options.results).resolve()
        / ("soak" if options.soak > 0.0 else Path(options.case).stem)
        / str(options.seed)
    )
    summary = folder / "summary.yaml"
    folder.mkdir(parents=True, exist_ok=True)
    if summary.exists():
        summary.unlink()
    port = options.port or free_port()
    environment = dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}")
    sys.stdout.write(f"ROS_MASTER_URI=http://localhost:{port}\n")
    sys.stdout.flush()
    child = subprocess.Popen(command(options, port), env=environment, start_new_session=True)
    code = _wait(child, wall_limit_s(options))
    if code == INTERRUPTED:
        return code
    return verdict(summary)


def command(options: argparse.Namespace, port: int) -> List[str]:
    """The roslaunch call for these options."""
    values = {
        "case": options.case,
        "seed": options.seed,
        "mode": options.mode,
        "planner": options.planner,
        "particles": options.particles,
        "speed": options.speed,
        "raster": options.raster,
        "limit_s": options.limit,
        "soak_s": options.soak,
        "results": Path(options.results).resolve(),
    }
    flags = {name: getattr(options, name) for name in ("rviz", "sync", "bag", "cleanup")}
    flags["sander"] = has_manipulator(options.case)
    flags["guarded"] = not options.unguarded
    arguments = [f"{name}:={value}" for name, value in values.items()]
    arguments += [f"{name}:={str(value).lower()}" for name, value in flags.items()]
    return ["roslaunch", "-p", str(port), "yarm", "experiment.launch", *arguments]


def wall_limit_s(options: argparse.Namespace) -> float:
    """Wall time the whole may take, s."""
    return float(options.wall_limit or MISSION_LIMIT_S + SLOWEST * options.soak)


def has_manipulator(case: str) -> bool:
    """Whether one works in a scene; a scene that cannot be read is left to the simulation to refuse."""
    try:
        return load_scene(case).has_working_arm
    except SceneError:
        return True


def verdict(summary: Path) -> int:
    """0 when the results say success."""
    if not summary.is_file():
        sys.stderr.write(f"the experiment ended without results: {summary} was not written; see the output above\n")
        return 1
    return 0 if yaml.safe_load(summary.read_text()).get("success") is True else 1


def free_port() -> int:
    """A port nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return int(probe.getsockname()[1])


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
            process.terminate()
        _, alive = psutil.wait_procs(alive, timeout=3.0)
        for process in alive:
            process.kill()
        if self._child.poll() is None:
            self._child.kill()
            self._child.wait()


def _wait(child: subprocess.Popen[bytes], limit_s: float) -> int:
    family = Family(child)
    deadline = time.monotonic() + limit_s
    try:
        while child.poll() is None and time.monotonic() < deadline:
            family.look()
            time.sleep(POLL_S)
    except KeyboardInterrupt:
        family.stop()
        return INTERRUPTED
    if child.poll() is None:
        sys.stderr.write(f"stopped after {limit_s:.0f} s of wall time (--wall-limit)\n")
    family.stop()
    return 0
