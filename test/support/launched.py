"""Runs a rostest or a gtest binary as a child process, with a limit, and stops everything it started."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path
from typing import Dict, List, Tuple

import psutil

from yarm.ros.experiment.launcher import Family

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("YARM_BUILD", ROOT / "build"))
DEVEL = BUILD / "devel" if "YARM_BUILD" in os.environ else ROOT / "devel"
MOST_CHARS = 4000
"""Of a failed child's output that are shown."""


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
    log, environment = _surroundings(name)
    with log.open("w") as output:
        child = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, env=environment, cwd=str(ROOT))
        late = False
        try:
            child.wait(timeout=limit_s)
        except subprocess.TimeoutExpired:
            late = True
        finally:
            Family(child).stop()
    text = log.read_text(errors="replace")
    if late or child.returncode != 0:
        why = f"was stopped after {limit_s:.0f} s" if late else f"ended with exit code {child.returncode}"
        raise LaunchedTestError(f"{' '.join(command)} {why}; whole output in {log}; its end:\n{_end_of(text)}")
    return text


def _end_of(text: str) -> str:
    """What says why: rostest's own report where there is one, and the last lines before it."""
    report = text.rfind("[ROSTEST]")
    if report < 0:
        return text[-MOST_CHARS:]
    return f"{text[report:][:MOST_CHARS]}\nbefore that:\n{text[:report][-MOST_CHARS:]}"


class Launched:
    """A child that runs while something is done with it, and is stopped with all it has started."""

    def __init__(self, command: List[str], name: str, environment: Dict[str, str], folder: Path) -> None:
        """Start it.

        Args:
            command: program and arguments.
            name: name of its log below the build folder.
            environment: what differs from this process's.
            folder: where it runs.
        """
        self._log, surroundings = _surroundings(name)
        with self._log.open("w") as output:
            self._child = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**surroundings, **environment},
                cwd=str(folder),
            )

    def __enter__(self) -> Launched:
        return self

    def __exit__(self, *_: object) -> None:
        Family(self._child).stop()

    def interrupt(self, limit_s: float) -> int:
        """What Ctrl-C does; its exit code. It has so many wall seconds to end."""
        self._child.send_signal(signal.SIGINT)
        return self._child.wait(timeout=limit_s)

    def ended(self, limit_s: float) -> int:
        """Its exit code, when it ends by itself. It has so many wall seconds to do so."""
        return self._child.wait(timeout=limit_s)

    def running(self) -> bool:
        """Whether it has not ended."""
        return self._child.poll() is None

    def kill(self, *words: str) -> None:
        """SIGKILL to the one process it has started whose command line has all these words, each an argument."""
        found = [p for p in psutil.Process(self._child.pid).children(recursive=True) if set(words) <= set(p.cmdline())]
        pids = [p.pid for p in found if not any(other.ppid() == p.pid for other in found)]
        assert len(pids) == 1, f"{words}: {found}"
        os.kill(pids[0], signal.SIGKILL)

    def output(self) -> str:
        """What it has printed so far."""
        return self._log.read_text(errors="replace")


def _surroundings(name: str) -> Tuple[Path, Dict[str, str]]:
    """Log of a child below the build folder, and an environment that keeps ROS's own files there."""
    log = BUILD / "test_logs" / f"{name}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    ros_home = log.parent / f"{name}.ros"
    environment = dict(os.environ, ROS_HOME=str(ros_home), ROS_LOG_DIR=str(ros_home / "log"))
    environment["ROS_TEST_RESULTS_DIR"] = str(ros_home / "results")
    # What a node says is read from a file while it runs; a file's lines would else wait until a buffer is full.
    environment["PYTHONUNBUFFERED"] = "1"
    return log, environment


def rostest_command(file: Path) -> List[str]:
    """Command that runs a .test file, wherever it lies, as one of this package."""
    return ["rostest", "--pkgdir", str(ROOT), "--package", "yarm", str(file)]
