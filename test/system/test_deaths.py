"""Deaths of what everything else hangs on: who records a mission, the simulation, the ROS master."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Callable, Dict, Iterator, List, Optional, Tuple

import psutil
import pytest
import yaml

from support.launched import ROOT, Launched
from yarm.ros.experiment.keep_running import GONE, STOPPED_BY, is_ours, pid_of_master
from yarm.ros.experiment.ports import free_port

LIMIT_S = 600.0
KEEP = [sys.executable, str(ROOT / "scripts" / "keep_running")]
CALL = [sys.executable, str(ROOT / "scripts" / "run_experiment"), "--case", "1m1ma", "--seed", "3", "--cleanup"]


def test_the_recorder_and_the_simulation_are_killed(tmp_path: Path) -> None:
    folder = tmp_path / "1m1ma_bin" / "3"
    with Launched([*CALL, "--results", str(tmp_path)], "deaths", {}, ROOT) as mission:

        def until(words: str, file: Path) -> None:
            deadline = time.monotonic() + LIMIT_S
            while not file.is_file() or words not in file.read_text(errors="replace"):
                assert mission.running() and time.monotonic() < deadline, f"no {words!r}: {mission.output()[-4000:]}"
                time.sleep(0.1)

        until("debris_1 moving", folder / "run.log")
        mission.kill("--node", "__name:=run_experiment")
        until("this process had died", folder / "run.log")
        mission.kill("__name:=simulation")
        until("the mission begins anew", folder / "run.log")
        assert mission.ended(LIMIT_S) == 0, mission.output()[-4000:]
        said = mission.output()
    assert "the cell began anew 1 times: its simulation was started again" in said
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert (summary["success"], summary["begun_again"], summary["unrecorded_s"]) == (True, 1, 0.0)
    assert not (folder / "run.saved").exists()


@pytest.fixture(name="master")
def fixture_master() -> Iterator[Tuple[str, Dict[str, str], Callable[[], None]]]:
    """Address of a ROS master that is not there yet, the environment with it, and who starts it."""
    port = free_port()
    environment = {"ROS_MASTER_URI": f"http://localhost:{port}"}
    started = []

    def start() -> None:
        call = ["rosmaster", "--core", "-p", str(port)]
        started.append(subprocess.Popen(call, env={**os.environ, **environment}, stdout=subprocess.DEVNULL))

    yield environment["ROS_MASTER_URI"], environment, start
    for process in started:
        process.kill()
        process.wait()


def output_of(call: List[str], environment: Dict[str, str]) -> str:
    """What it prints; nothing when it fails."""
    done = subprocess.run(call, env=environment, capture_output=True, text=True, check=False)
    return done.stdout.strip() if done.returncode == 0 else ""


def simulation_at(uri: str, before: Optional[int], kept: Launched) -> int:
    """Process of the simulation that a master knows, once it is another one."""
    lookup = "import rosgraph, sys; print(rosgraph.Master('/who_looks').lookupNode('/simulation'))"
    ask = "import sys, xmlrpc.client; print(xmlrpc.client.ServerProxy(sys.argv[1]).getPid('/who_looks')[2])"
    environment = {**os.environ, "ROS_MASTER_URI": uri}
    deadline = time.monotonic() + LIMIT_S
    while time.monotonic() < deadline and kept.running():
        where = output_of([sys.executable, "-c", lookup], environment)
        if where:
            found = output_of([sys.executable, "-c", ask, where], environment)
            if found and int(found) != before:
                return int(found)
        time.sleep(0.2)
    raise AssertionError(f"no other simulation at {uri}: {kept.output()[-4000:]}")


@pytest.mark.parametrize("foreign", [False, True])
def test_a_launch_file_outlives_its_ros_master(master, foreign: bool) -> None:
    uri, environment, start = master
    if foreign:
        start()
        while pid_of_master(uri) in (GONE, None):
            time.sleep(0.1)
    call = [*KEEP, "simulation.launch", "scene:=single"]
    with Launched(call, f"keep_running_{foreign}", environment, ROOT) as kept:
        first = simulation_at(uri, None, kept)
        pid = pid_of_master(uri)
        assert pid is not None and pid != GONE
        ask = f"import rosgraph; rosgraph.Master('/who_stops').setParam('{STOPPED_BY}', 'a person')"
        output_of([sys.executable, "-c", ask], {**os.environ, **environment})
        time.sleep(1.0)
        os.kill(pid, signal.SIGSTOP)
        time.sleep(1.0)
        os.kill(pid, signal.SIGCONT)
        assert simulation_at(uri, None, kept) == first, "a master that hangs for a moment ends nothing"
        os.kill(pid, signal.SIGKILL)
        if foreign:
            while f"waits for a ROS master at {uri}" not in kept.output():
                assert kept.running()
                time.sleep(0.1)
            start()
        second = simulation_at(uri, first, kept)
        assert not psutil.pid_exists(first)
        assert f"the ROS master at {uri} is gone" in kept.output()
        ask = f"import rosgraph; print(rosgraph.Master('/who_looks').getParam('{STOPPED_BY}'))"
        assert output_of([sys.executable, "-c", ask], {**os.environ, **environment}) == "a person"
        assert kept.interrupt(LIMIT_S) == 128 + signal.SIGINT
        assert not psutil.pid_exists(second)
    assert (pid_of_master(uri) != GONE) is foreign, "a master of somebody else is left alone"


def test_what_roslaunch_refuses_is_handed_on(master) -> None:
    uri, environment, _ = master
    with Launched([*KEEP, "simulation.launch", "scene:=nowhere"], "keep_refused", environment, ROOT) as kept:
        assert kept.ended(LIMIT_S) == 1
        assert "nowhere" in kept.output()
    assert pid_of_master(uri) == GONE
    with Launched([*KEEP], "keep_nothing", environment, ROOT) as kept:
        assert kept.ended(LIMIT_S) == 2
        assert "usage: keep_running LAUNCH_FILE" in kept.output()


def test_a_master_of_another_machine_is_awaited_and_not_started_here() -> None:
    assert is_ours("http://localhost:11311") and is_ours("http://127.0.0.1:11311")
    assert not is_ours("http://robot.example:11311")
