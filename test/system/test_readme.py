"""Every command of the README, in its blocks and in its sentences, run as it stands there."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import time
from contextlib import suppress
from pathlib import Path
from typing import Callable, Dict, Iterator, List
from urllib.error import URLError
from urllib.request import urlopen

import pytest
import yaml

from support.launched import ROOT, Launched, run
from yarm.ros.experiment.ports import free_port

README = (ROOT / "README.md").read_text(encoding="utf-8")
LIMIT_S = 600.0
MISSION = "the mission by hand"
WORKSPACE = "the catkin workspace"
RECORDED = "the recorded experiment"
EXPLORED = "the exploration"
INSPECTED = "the inspection"
REPEATED = "the run in lock-step"
ALONE = "alone"
CI = "continuous integration"
HOURS = "hours: only what it would call"
NODES = "test/ros/real_cell.test"
FLOOR = "test/ros/youbot_floor.test"
COURSEWORK = "test/python/experiments/coursework"
WHERE: Dict[str, str] = {
    "make demo": CI,
    "make demo CONSOLE=1": CI,
    "make test": CI,
    "roslaunch yarm full_system.launch scene:=1m1ma_bin rviz:=true": MISSION,
    'rosservice call /commander_state "{next_state: true}"': MISSION,
    'rosservice call /commander_state "{jump_state: 5}"': MISSION,
    "rostopic echo /commander/status": MISSION,
    "rosrun yarm run_experiment --case 2m1ma --seed 3 --bag": RECORDED,
    "roslaunch yarm replay.launch bag:=$PWD/results/2m1ma_bin/3/run.bag": RECORDED,
    "rosrun yarm console --run results/2m1ma_bin/3": RECORDED,
    "roslaunch yarm exploration.launch arena:=practice rviz:=true": EXPLORED,
    "rosrun yarm run_experiment --case explore --arena practice --controller yarm --seed 3": EXPLORED,
    "roslaunch yarm inspection.launch layout:=practice rviz:=true": INSPECTED,
    "rosrun yarm run_experiment --case inspect --layout practice --controller yarm --seed 3": INSPECTED,
    "python3 -m yarm.planning scenes/planning/three_robots.yaml --steps --plot three_robots.png": ALONE,
    "rosrun yarm cell_check 2m1ma": ALONE,
    "rosrun yarm snapshot 2m1ma cell.png": ALONE,
    "src/yarm/tools/setup.sh": WORKSPACE,
    "source src/yarm/tools/env.sh": WORKSPACE,
    "catkin_make -DCMAKE_BUILD_TYPE=Release install": WORKSPACE,
    "source install/setup.bash": WORKSPACE,
    "source tools/env.sh": CI,
    "rosrun yarm commander_cli run --mode boundless": MISSION,
    "rosrun yarm console": MISSION,
    "rosrun yarm what_if --robots 1..3": MISSION,
    "rosrun yarm what_if --case 2m1ma --planner yarm,lacam --runs 4": ALONE,
    "rosrun yarm replay_to --run results/1m1ma_bin/3 --decision 10": REPEATED,
    "roslaunch yarm real_cell.launch cell:=FILE": NODES,
    "roslaunch yarm youbot.launch clear:=true console:=true": FLOOR,
    "make demo CASE=coursework": COURSEWORK,
    "make reproduce": HOURS,
    "make bench": HOURS,
}
IGNORED = shutil.ignore_patterns(
    ".git", ".venv", "build", "devel", "install", "log", "results", "__pycache__", ".*cache"
)


def commands() -> List[str]:
    """Lines of the README's code blocks without their comments, and the commands in its sentences."""
    blocks = re.findall(r"^```\n(.*?)^```", README, re.M | re.S)
    lines = [re.sub(r"\s+#.*", "", line).strip() for block in blocks for line in block.splitlines()]
    lines += re.findall(r"`((?:make|ros\w+|python3|source|catkin_make) [^`\n]+)`", README)
    return [line for line in dict.fromkeys(lines) if line]


def of(where: str) -> List[str]:
    return [command for command in commands() if WHERE[command] == where]


def test_none_is_left_out() -> None:
    assert sorted(commands()) == sorted(WHERE)


@pytest.mark.parametrize(("given", "options"), [([], ""), (["CONSOLE=1"], " --console")])
def test_make_demo_is_an_experiment(given: List[str], options: str) -> None:
    call = ["make", "-n", "--no-print-directory", "demo", *given]
    recipe = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert f"rosrun yarm run_experiment --case 1m1ma{options} --seed 3\n" in recipe  # test_experiment_runs.py runs it


@pytest.mark.parametrize(("command", "call"), zip(of(HOURS), ("rosrun yarm reproduce", "python3 bench/run_all.py")))
def test_what_takes_hours_calls_what_there_is(command: str, call: str) -> None:
    recipe = subprocess.run([*command.split(), "-n"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert call in recipe


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A folder that looks like the checkout to whoever reads scenes, and takes what is written."""
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    return tmp_path


@pytest.mark.parametrize("command", of(ALONE))
def test_alone(command: str, place: Path) -> None:
    run(["bash", "-c", f"cd {place} && {command}"], "readme_" + command.split()[2], LIMIT_S)
    picture = re.search(r"\w+\.png", command)
    made = "results/what_if/answer.png" if "what_if" in command else picture and picture.group()
    assert made is None or (place / made).stat().st_size > 10_000


@pytest.fixture
def display() -> Iterator[str]:
    """A screen nobody sees."""
    read, write = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x800x24"], pass_fds=[write], stderr=subprocess.DEVNULL
    )
    try:
        os.close(write)
        with os.fdopen(read) as number:
            yield ":" + number.readline().strip()
    finally:
        server.terminate()
        server.wait()


def wait(ready: Callable[[], bool], what: str, child: Launched) -> None:
    deadline = time.monotonic() + LIMIT_S
    while not ready():
        assert time.monotonic() < deadline, f"no {what} within {LIMIT_S:.0f} s:\n{child.output()[-4000:]}"
        assert child.running(), f"it ended before {what}:\n{child.output()[-4000:]}"
        time.sleep(0.5)


def surroundings(display: str) -> Dict[str, str]:
    """A ROS master's address of one's own, and the screen."""
    uri = f"http://localhost:{free_port()}"
    return {"ROS_MASTER_URI": uri, "DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1"}


def test_mission_by_hand(display: str, place: Path) -> None:
    launch, to_next, to_mission, echo, to_the_end, console, what_if = of(MISSION)
    environment = surroundings(display)

    def call(command: str, limit_s: float = 120.0) -> str:
        done = subprocess.run(
            ["bash", "-c", command],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=limit_s,
            check=False,
        )
        return done.stdout + done.stderr

    with Launched(launch.split(), "readme_mission", environment, place) as system:
        wait(lambda: "success: True" in call(to_next), "STARTED", system)
        wait(lambda: "success: True" in call(to_next), "CALIBRATION", system)
        wait(lambda: "success: True" in call(to_next), "MENU after the calibration", system)
        assert "success: True" in call(to_mission)
        status = call(echo.replace("echo", "echo -n1"))
        assert 'state_name: "BOUNDLESS"' in status
        assert "/rviz" in call("rosnode list")
        previous = call('rosservice call /commander_state "{previous_state: true}"')
        assert "success: True" in previous, previous
        wait(lambda: "busy: False" in call("rostopic echo -n1 /commander/status"), "stop", system)
        with Launched(["bash", "-c", f"exec {console} _port:=0"], "readme_beside", environment, place) as page:
            serves_the_page(page)
        thing = "{name: target_1, type: Target, x: 1.0, y: 1.6, z: 0.89}"
        assert "success: True" in call(f'rosservice call /spawn_obstacles "{thing}"')
        asked = f"cd {place} && {what_if} --runs 1"
        wait(lambda: "4 runs in" in call(asked, LIMIT_S), "answer to what if", system)
        assert (place / "results" / "what_if" / "answer.png").is_file()
        assert "success: True" in call("rosservice call /delete_obstacles '{name: target_1}'")
        done = call(to_the_end, LIMIT_S)
        assert "succeeded" in done or "reached" in done, done


def replayed(command: str, name: str, environment: Dict[str, str], place: Path) -> None:
    """A recording is played for five seconds."""
    with Launched(command.split(), name, environment, place) as shown:
        wait(lambda: "[RUNNING]" in shown.output(), "replay", shown)
        started = time.monotonic()
        wait(lambda: time.monotonic() - started > 5.0, "five seconds of replay", shown)
    assert "[play" in shown.output()


def serves_the_page(child: Launched) -> None:
    """It prints an address, and the page is there."""
    printed = re.compile(r"console: (http://[^\s?#]+)")
    wait(lambda: printed.search(child.output()) is not None, "the page's address", child)
    address = printed.findall(child.output())[0]

    def answers() -> bool:
        with suppress(URLError), urlopen(address, timeout=LIMIT_S) as answer:
            return answer.status == 200 and b"<html" in answer.read()
        return False

    wait(answers, "the page", child)


def test_recorded_and_replayed(display: str, place: Path) -> None:
    """The experiment with its page beside it, as ``make demo CONSOLE=1`` has it."""
    experiment, replay, console = of(RECORDED)
    environment = surroundings(display)
    command = ["bash", "-c", f"cd {place} && exec {experiment} --console"]
    with Launched(command, "readme_recorded", environment, place) as shown:
        serves_the_page(shown)
        assert "#token=" in shown.output()
        assert shown.ended(LIMIT_S) == 0, shown.output()[-4000:]
    replayed(replay.replace("$PWD", str(place)), "readme_replay", environment, place)
    with Launched(["bash", "-c", f"cd {place} && exec {console}"], "readme_console", environment, place) as page:
        serves_the_page(page)
    run(["bash", "-c", f"cd {place} && {console} --export run.html"], "readme_export", LIMIT_S)
    assert "2m1ma_bin/3" in (place / "run.html").read_text(encoding="utf-8")


def test_brought_to_a_decision_again(place: Path) -> None:
    (replay,) = of(REPEATED)
    experiment = "rosrun yarm run_experiment --case 1m1ma --seed 3 --sync --speed 0"
    run(["bash", "-c", f"cd {place} && {experiment}"], "readme_repeated", LIMIT_S)
    output = run(["bash", "-c", f"cd {place} && {replay} --end"], "readme_replay_to", LIMIT_S)
    assert re.search(r"decision 10, \w+", output), output[-4000:]
    folder = place / "results" / "1m1ma_bin" / "3"
    decisions = yaml.safe_load((folder / "summary.yaml").read_text())["decisions"]
    whole = replay.replace("--decision 10", f"--decision {decisions['count']}")
    run(["bash", "-c", f"cd {place} && {whole} --end"], "readme_replay_whole", LIMIT_S)
    again = yaml.safe_load((folder / "replay" / "1m1ma_bin" / "3" / "replay.yaml").read_text())
    assert again["hash"] == decisions["hash"], "with hands and a bin, too, a mission is the same to its last decision"


def test_explored(display: str, place: Path) -> None:
    launch, experiment = of(EXPLORED)
    environment = {**surroundings(display), "PWD": str(place)}  # a shell sets it; the map is saved there
    with Launched(launch.split(), "readme_exploration", environment, place) as shown:
        wait(lambda: "from idle, to exploring" in shown.output(), "the start of the exploration", shown)
    output = run(["bash", "-c", f"cd {place} && {experiment}"], "readme_explored", LIMIT_S)
    assert "practice, yarm, seed 3: SUCCESS" in output
    assert (place / "results" / "explore" / "practice" / "yarm" / "3" / "map.pgm").is_file()


def test_inspected(display: str, place: Path) -> None:
    launch, experiment = of(INSPECTED)
    environment = {**surroundings(display), "PWD": str(place)}  # a shell sets it; the result is written there
    with Launched(launch.split(), "readme_inspection", environment, place) as shown:
        wait(lambda: " s, verdict: box " in shown.output(), "the first verdict", shown)
    output = run(["bash", "-c", f"cd {place} && {experiment} --bag"], "readme_inspected", LIMIT_S)
    assert "practice, yarm, seed 3: SUCCESS" in output
    folder = place / "results" / "inspect" / "practice" / "yarm" / "3"
    assert (folder / "proof.html").is_file()
    replay = f"roslaunch yarm replay.launch bag:={folder / 'run.bag'} mission:=inspection"
    replayed(replay, "readme_inspected_replay", surroundings(display), place)


@pytest.mark.parametrize("case", ["explore", "inspect"])  # test_explored and test_inspected run them
def test_make_demo_of_a_room(case: str) -> None:
    recipe = subprocess.run(
        ["make", "-n", "--no-print-directory", "demo", f"CASE={case}"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert f"rosrun yarm run_experiment --case {case} --seed 3" in recipe


def test_catkin_workspace(tmp_path: Path) -> None:
    checkout = tmp_path / "src" / "yarm"
    shutil.copytree(ROOT, checkout, ignore=IGNORED)
    (checkout / ".venv").symlink_to(ROOT / ".venv")
    lines = [f"cd {tmp_path}", *of(WORKSPACE), "cd /", "rospack find yarm", "rosrun yarm cell_check 2m1ma"]
    lines += [f"rosrun yarm run_experiment --case single --seed 1 --sync --speed 0 --results {tmp_path}/results"]
    clean = ["env", "-u", "CMAKE_PREFIX_PATH", "-u", "ROS_PACKAGE_PATH", "-u", "PYTHONPATH", "-u", "YARM_BUILD"]
    output = run([*clean, "bash", "-ec", "\n".join(lines)], "readme_workspace", 1800.0)
    assert f"{tmp_path}/install/share/yarm" in output
    assert "single, seed 1, boundless: SUCCESS" in output
