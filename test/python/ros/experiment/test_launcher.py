"""The launcher's verdict and its roslaunch call (nothing is launched)."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from yarm.experiments.run.cases import CASES
from yarm.ros.experiment.launcher import (
    Family,
    case_to_run,
    command,
    exploration_command,
    folder_of,
    inspection_command,
    parser,
    run,
    verdict,
    wall_limit_s,
)
from yarm.sim.scenes.scene import load_scene


@pytest.mark.parametrize(
    ("text", "code"), [("success: true\n", 0), ("success: false\n", 1), ("success: 'true'\n", 1), ("{}\n", 1)]
)
def test_only_success_is_zero(tmp_path: Path, text: str, code: int) -> None:
    summary = tmp_path / "summary.yaml"
    summary.write_text(text)
    assert verdict(summary) == code


def test_no_results_are_a_failure_that_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert verdict(tmp_path / "summary.yaml") == 1
    assert "summary.yaml was not written" in capsys.readouterr().err


def test_every_option_becomes_a_launch_argument_that_exists(tmp_path: Path) -> None:
    options = parser().parse_args(["--case", "3m", "--seed", "7", "--sync", "--results", str(tmp_path)])
    call = command(options, 12345)
    assert call[:5] == ["roslaunch", "-p", "12345", "yarm", "experiment.launch"]
    given = dict(argument.split(":=") for argument in call[5:])
    assert (given["case"], given["seed"], given["sync"], given["rviz"]) == ("3m", "7", "true", "false")
    assert (given["sander"], given["guarded"]) == ("false", "true")
    assert (given["vary"], given["replanning"]) == ("true", "true")
    published = parser().parse_args(["--nominal", "--planned-once", "--unguarded"])
    assert {"vary:=false", "replanning:=false", "guarded:=false"} <= set(command(published, 1))
    launch = (Path(__file__).parents[4] / "launch" / "cell" / "experiment.launch").read_text()
    assert all(f'<arg name="{name}" default=' in launch for name in given)


@pytest.mark.parametrize(
    ("words", "policy"),
    [
        ([], "known_bodies"),
        (["--planner", "original"], "free"),
        (["--planner", "original", "--hidden", "occupied"], "occupied"),
    ],
)
def test_what_no_camera_sees_is_free_with_the_published_planner_alone(words: list, policy: str) -> None:
    """It is always named: what repeats a mission goes by it, whatever the launch file's default is by then."""
    assert f"hidden:={policy}" in command(parser().parse_args(words), 11311)
    for file in ("experiment", "full_system", "real_cell"):
        text = (Path(__file__).parents[4] / "launch" / "cell" / f"{file}.launch").read_text()
        assert """name="hidden" default="$(eval 'free' if arg('planner') == 'original' else 'known_bodies')\"""" in text


def test_an_exploration_has_a_launch_file_of_its_own(tmp_path: Path) -> None:
    words = ["--case", "explore", "--controller", "nearest", "--limit", "60", "--results", str(tmp_path)]
    options = parser().parse_args(words)
    call = exploration_command(options, 12345)
    assert call[:5] == ["roslaunch", "-p", "12345", "yarm", "explore_experiment.launch"]
    given = dict(argument.split(":=") for argument in call[5:])
    assert (given["arena"], given["controller"], given["time_limit_s"]) == ("practice", "nearest", "60.0")
    assert (given["sync"], given["real_time_factor"]) == ("true", "0.0")
    assert given["folder"] == str(tmp_path / "explore" / "practice" / "nearest" / "3")
    launch = (Path(__file__).parents[4] / "launch" / "exploration" / "explore_experiment.launch").read_text()
    assert all(f'<arg name="{name}" default=' in launch for name in given)


def test_an_inspection_has_one_too(tmp_path: Path) -> None:
    words = ["--case", "inspect", "--layout", "wall_7", "--controller", "report", "--results", str(tmp_path)]
    options = parser().parse_args(words)
    call = inspection_command(options, 12345)
    assert call[:5] == ["roslaunch", "-p", "12345", "yarm", "inspect_experiment.launch"]
    given = dict(argument.split(":=") for argument in call[5:])
    assert (given["layout"], given["controller"], given["sync"]) == ("wall_7", "report", "true")
    assert given["folder"] == str(tmp_path / "inspect" / "wall_7" / "report" / "3")
    launch = (Path(__file__).parents[4] / "launch" / "inspection" / "inspect_experiment.launch").read_text()
    assert all(f'<arg name="{name}" default=' in launch for name in given)
    assert run(["--case", "inspect", "--layout", "nowhere", "--results", str(tmp_path / "none")]) == 1
    assert not (tmp_path / "none").exists()


def test_a_speed_that_is_asked_for_ends_the_lock_step_and_a_file_is_found_from_anywhere() -> None:
    options = parser().parse_args(["--case", "explore", "--speed", "1", "--arena", "somewhere/room.yaml"])
    given = dict(argument.split(":=") for argument in exploration_command(options, 1)[5:])
    assert (given["sync"], given["real_time_factor"]) == ("false", "1.0")
    assert given["arena"] == str(Path("somewhere/room.yaml").resolve())
    assert folder_of(options).parts[-4:] == ("explore", "room", "yarm", "3")


@pytest.mark.parametrize(("words", "said"), [(["--controller", "best"], "best"), (["--arena", "nowhere"], "nowhere")])
def test_a_wrong_controller_or_arena_is_refused_before_anything_starts(words, said, tmp_path, capsys) -> None:
    assert run(["--case", "explore", "--results", str(tmp_path), *words]) == 1
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_an_inspection_has_controllers_of_its_own(tmp_path, capsys) -> None:
    assert run(["--case", "inspect", "--results", str(tmp_path), "--controller", "nearest"]) == 1
    said = capsys.readouterr().err
    assert said == "launch argument controller = 'nearest': must be one of yarm, report, report_printed\n"
    assert list(tmp_path.iterdir()) == []


def test_the_sander_is_left_out_where_there_is_no_manipulator() -> None:
    assert "sander:=false" in command(parser().parse_args(["--case", "single"]), 1)
    assert "sander:=true" in command(parser().parse_args(["--case", "no_such_scene"]), 1)


def test_a_soak_has_the_time_it_needs() -> None:
    assert wall_limit_s(parser().parse_args([])) == 900.0
    assert wall_limit_s(parser().parse_args(["--soak", "3600"])) == 900.0 + 4 * 3600.0
    assert wall_limit_s(parser().parse_args(["--soak", "3600", "--wall-limit", "60"])) == 60.0


def test_orphans_of_the_child_are_ended_too() -> None:
    sleeper = "import time; time.sleep(600)"
    spawning = (
        f"import subprocess, sys; print(subprocess.Popen([sys.executable, '-c', '{sleeper}']).pid, flush=True); input()"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", spawning],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        start_new_session=True,
        text=True,
    )
    assert child.stdin is not None
    assert child.stdout is not None
    orphan = psutil.Process(int(child.stdout.readline()))
    family = Family(child)  # type: ignore[arg-type]
    family.look()
    child.stdin.close()
    child.wait(timeout=30)
    assert orphan.is_running()
    family.stop()
    deadline = time.monotonic() + 30.0
    while orphan.is_running() and orphan.status() != psutil.STATUS_ZOMBIE and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not orphan.is_running() or orphan.status() == psutil.STATUS_ZOMBIE


def test_a_number_that_is_somebody_elses_by_now_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    child = subprocess.Popen([sys.executable, "-c", ""])
    somebody = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    try:
        known = psutil.Process(somebody.pid)
        monkeypatch.setattr(known, "_ident", (known.pid, known.create_time() - 60.0))
        monkeypatch.setattr(psutil.Process, "children", lambda *_, **__: [known])
        Family(child).stop()
        assert somebody.poll() is None
    finally:
        somebody.kill()
        somebody.wait()


FAKE_ROSLAUNCH = """#!{python}
import sys
from pathlib import Path
given = dict(word.split(":=") for word in sys.argv if ":=" in word)
print("PARAMETERS\\n * /commander/seed: 1", flush=True)
print("[experiment]   1.0 s | x1.0 | 3 waypoints", flush=True)
print("\\x1b[31m[ERROR] no grid for 3 s\\x1b[0m", file=sys.stderr, flush=True)
print("[experiment]\\n[experiment] single, seed 4: {verdict}", flush=True)
print("\\x1b[31mREQUIRED process [run_experiment-9] has died!", flush=True)
print("process has died [pid 7, exit code 1, cmd /y/run_experiment --node __name:=run_experiment].", flush=True)
folder = Path(given["results"]) / given["case"] / given["seed"]
(folder / "summary.yaml").write_text("success: {success}\\nfaults: {faults}")
"""


@pytest.mark.parametrize("success", ["true", "false"])
def test_a_person_sees_progress_and_the_verdict_and_the_log_has_the_rest(
    success: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    fake = tmp_path / "bin" / "roslaunch"
    fake.parent.mkdir()
    verdict_text = "SUCCESS" if success == "true" else "FAILED"
    faults = "[]" if success == "true" else "[target_1 lies in no bin]"
    text = FAKE_ROSLAUNCH.format(python=sys.executable, success=success, verdict=verdict_text, faults=faults)
    fake.write_text(text)
    fake.chmod(0o755)
    monkeypatch.setenv("PATH", str(fake.parent) + os.pathsep + os.environ["PATH"])
    code = run(["--case", "single", "--seed", "4", "--results", str(tmp_path / "results")])
    log = tmp_path / "results" / "single" / "4" / "run.log"
    said = capsys.readouterr()
    lines = said.out.splitlines()
    assert lines[0].startswith("single, seed 4: ROS_MASTER_URI=http://localhost:")
    assert lines[1:] == ["  1.0 s | x1.0 | 3 waypoints", "", f"single, seed 4: {verdict_text}", f"log: {log}"]
    assert "PARAMETERS" in log.read_text()
    assert code == (0 if success == "true" else 1)
    last = [f"the last of {log}:", "  [ERROR] no grid for 3 s", "wrong: target_1 lies in no bin"]
    assert said.err.splitlines() == ([] if code == 0 else last)


@pytest.mark.parametrize(
    ("case", "arms"), [("1m1ma", "hc10_barc"), ("2m2ma", "hc10_barc hc10_barc_2"), ("no such scene", "hc10_barc")]
)
def test_every_manipulator_of_the_case_gets_a_sander(case: str, arms: str) -> None:
    given = dict(word.split(":=") for word in command(parser().parse_args(["--case", case]), 1)[5:])
    assert (given["arms"], given["sander"]) == (arms, "true")


def test_wrong_words_are_refused_before_anything_is_started_or_lost(tmp_path, capsys):
    summary = tmp_path / "nope" / "3" / "summary.yaml"
    summary.parent.mkdir(parents=True)
    summary.write_text("success: true\n")
    assert run(["--case", "nope", "--planner", "magic", "--results", str(tmp_path)]) == 1
    said = capsys.readouterr().err
    assert "launch argument case = 'nope': no such scene; shipped: 1m1ma" in said
    assert "launch argument planner = 'magic'" in said
    assert summary.read_text() == "success: true\n"


def test_stray_debris_is_looked_for_where_the_scene_has_some_or_where_it_is_asked_for() -> None:
    def size(*words: str) -> str:
        return dict(word.split(":=") for word in command(parser().parse_args(words), 1)[5:])["debris_size"]

    unnamed = str(Path(__file__).parents[3] / "system" / "mission_unnamed.yaml")
    assert [size("--case", case) for case in ("1m1ma", "no_such_scene", unnamed)] == ["0.0", "0.0", "0.25"]
    assert size("--case", unnamed, "--debris-size", "0") == "0.0"
    assert size("--case", "1m1ma", "--debris-size", "0.1") == "0.1"


@pytest.mark.parametrize(
    ("words", "hands", "removal"),
    [
        (["--case", "1m1ma"], "false", "delete"),
        (["--case", "1m1ma", "--hands"], "true", "delete"),
        (["--case", "1m1ma_bin"], "true", "bin"),
        (["--case", "1m1ma_bin", "--removal", "delete"], "true", "delete"),
        (["--case", "no_such_scene"], "false", "delete"),
    ],
)
def test_in_a_cell_with_a_bin_robots_have_hands_and_use_it(words: list, hands: str, removal: str) -> None:
    given = dict(word.split(":=") for word in command(parser().parse_args(words), 1)[5:])
    assert (given["hands"], given["removal"]) == (hands, removal)


@pytest.mark.parametrize(
    ("words", "turns"),
    [
        (["--case", "3m"], "[0.0, 90.0, -90.0]"),
        (["--case", "1m1ma_bin"], "[0.0, 90.0, -90.0, 45.0, -45.0]"),
        (["--case", "1m1ma_bin", "--removal", "delete"], "[0.0, 90.0, -90.0]"),
        (["--case", "3m", "--turns", "0,30,-30"], "[0.0, 30.0, -30.0]"),
    ],
)
def test_robots_that_carry_debris_to_a_bin_make_finer_turns(words: list, turns: str) -> None:
    given = dict(word.split(":=") for word in command(parser().parse_args(words), 1)[5:])
    assert given["turns_deg"] == turns


@pytest.mark.parametrize("words", ["a", "", "0,", "0,181", "nan"])
def test_turns_that_are_none_are_refused(words: str, capsys: pytest.CaptureFixture) -> None:
    with pytest.raises(SystemExit):
        parser().parse_args(["--turns", words])
    assert f"{words!r}: angles within -180 to 180 deg, separated by commas" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "case"),
    [
        ([], "1m1ma_bin"),
        (["--case", "2m1ma"], "2m1ma_bin"),
        (["--case", "2m1ma", "--removal", "delete"], "2m1ma"),
        (["--case", "2m1ma", "--soak", "60"], "2m1ma"),
        (["--case", "3m"], "3m"),
        (["--case", "somewhere/cell.yaml"], "somewhere/cell.yaml"),
    ],
)
def test_debris_goes_to_a_bin_unless_it_is_to_be_deleted_as_published(words: list, case: str) -> None:
    assert case_to_run(parser().parse_args(words)) == case
    shipped = load_scene(case) if case in CASES else None
    assert shipped is None or bool(shipped.bins) is case.endswith("_bin")
