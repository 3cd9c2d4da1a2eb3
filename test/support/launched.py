"""Runs a rostest or a gtest binary as a child process, with a limit, and stops everything it started."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path
from typing import List

import psutil

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("YARM_BUILD", ROOT / "build"))
DEVEL = BUILD / "devel" if "YARM_BUILD" in os.environ else ROOT / "devel"
STOP_LIMIT_S = 60.0


class LaunchedTestError(AssertionError):
    """A launched test failed or ran out of time; the message holds the end of its output and names its log."""


def run(command: List[str], name: str, limit_s: float) -> str:
    """Run a command to its end and give back its output.

    Args:
        command: program and arguments.
        name: name of its log below the build folder.
        limit_s: wall seconds after which it is interrupted and has failed.

    Raises:
        LaunchedTestError: exit code not 0, or out of time.
    """
    log = BUILD / "test_logs" / f"{name}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    ros_home = log.parent / f"{name}.ros"
    environment = dict(os.environ, ROS_HOME=str(ros_home), ROS_LOG_DIR=str(ros_home / "log"))
    environment["ROS_TEST_RESULTS_DIR"] = str(ros_home / "results")
    with log.open("w") as output:
        child = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, env=environment, cwd=str(ROOT))
        late = False
        try:
            child.wait(timeout=limit_s)
        except subprocess.TimeoutExpired:
            late = True
        finally:
            _stop(child)
    text = log.read_text(errors="replace")
    if late or child.returncode != 0:
        why = f"was stopped after {limit_s:.0f} s" if late else f"ended with exit code {child.returncode}"
        raise LaunchedTestError(f"{' '.join(command)} {why}; whole output in {log}; its end:\n{text[-6000:]}")
    return text


def rostest_command(file: Path) -> List[str]:
    """Command that runs a .test file, wherever it lies, as one of this package."""
    return ["rostest", "--pkgdir", str(ROOT), "--package", "yarm", str(file)]


def _stop(child: subprocess.Popen) -> None:
    """End the child and whatever it started, gently first."""
    try:
        family = psutil.Process(child.pid).children(recursive=True)
    except psutil.NoSuchProcess:
        family = []
    if child.poll() is None:
        child.send_signal(signal.SIGINT)
        deadline = time.monotonic() + STOP_LIMIT_S
        while child.poll() is None and time.monotonic() < deadline:
            time.sleep(0.1)
    if child.poll() is None:
        child.kill()
        child.wait()
    _, alive = psutil.wait_procs(family, timeout=1.0)
    for process in alive:
        process.kill()
