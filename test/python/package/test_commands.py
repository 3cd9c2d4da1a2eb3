"""The make commands say in one message what is wrong, name it and the remedy, and end with a non-zero exit code."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Dict

import pytest

ROOT = Path(__file__).resolve().parents[3]
TOOLS = (
    "bash",
    "cat",
    "comm",
    "cut",
    "dirname",
    "env",
    "getent",
    "grep",
    "mkdir",
    "sed",
    "sh",
    "sleep",
    "sort",
    "tail",
    "tr",
    "wc",
)
"""All that the set-up calls before it installs anything."""


def run(command, **more) -> subprocess.CompletedProcess:
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, **more)


def test_an_unknown_make_variable_is_named() -> None:
    ended = run(["make", "-C", str(ROOT), "--no-print-directory", "help", "COLOUR=red"])
    assert ended.returncode != 0
    assert "unknown variable COLOUR: make knows CASE CONSOLE SEED TESTS; see `make help`" in ended.stderr


def test_a_known_variable_may_hold_several_words() -> None:
    ended = run(["make", "-n", "-C", str(ROOT), "--no-print-directory", "test", "TESTS=-k name --maxfail=2"])
    assert ended.returncode == 0, ended.stderr
    assert "tools/test.sh -k name --maxfail=2" in ended.stdout


@pytest.mark.parametrize(
    ("case", "calls"),
    [
        ("CASE=2m1ma", "rosrun yarm run_experiment --case 2m1ma --seed 3"),
        ("CASE=2m1ma CONSOLE=1", "rosrun yarm run_experiment --case 2m1ma --console --seed 3"),
        ("CASE=coursework", "rosrun yarm coursework --seed 3"),
    ],
)
def test_the_demo_calls_what_its_case_needs(case: str, calls: str) -> None:
    ended = run(["make", "-n", "-C", str(ROOT), "--no-print-directory", "demo", *case.split()])
    assert ended.returncode == 0, ended.stderr
    assert calls in ended.stdout


@pytest.mark.parametrize(
    ("fast", "slow", "verdict"),
    [(0, 0, 0), (1, 0, 1), (0, 1, 1), (2, 1, 2), (5, 0, 0), (0, 5, 0), (5, 1, 1), (1, 5, 1), (5, 5, 5)],
)
def test_both_parts_of_the_tests_run_and_the_worse_one_counts(
    tmp_path: Path, fast: int, slow: int, verdict: int
) -> None:
    """pytest gives 5 when it finds no test: a selection may leave nothing of one part, not of both."""
    log = tmp_path / "log"
    write(tmp_path / "python3", f'echo "$@" >>{log}; case "$*" in *test/python*) exit {fast};; esac; exit {slow}')
    environment = {"PATH": f"{tmp_path}:/usr/bin:/bin"}
    ended = run(["/bin/bash", str(ROOT / "tools" / "test.sh"), "-k", "one or two"], env=environment)
    assert ended.returncode == verdict
    first, second = log.read_text().splitlines()
    assert "--dist loadfile test/python test/contract -k one or two" in first
    assert re.fullmatch(r"-m pytest -n [12] --dist loadgroup test/cpp test/ros test/system -k one or two", second)
    assert {path.name for path in (ROOT / "test").iterdir() if list(path.rglob("test_*.py"))} == {
        word.split("/")[1] for line in (first, second) for word in line.split() if word.startswith("test/")
    }


def test_the_fast_part_can_be_run_alone(tmp_path: Path) -> None:
    log = tmp_path / "log"
    write(tmp_path / "python3", f'echo "$@" >>{log}; exit 5')
    environment = {"PATH": f"{tmp_path}:/usr/bin:/bin"}
    ended = run(["/bin/bash", str(ROOT / "tools" / "test.sh"), "fast"], env=environment)
    assert ended.returncode == 5
    assert len(log.read_text().splitlines()) == 1


@pytest.fixture
def bare(tmp_path: Path) -> Path:
    """A checkout's tools on a system without a single package of ours, and with an installer that fails."""
    shutil.copytree(ROOT / "tools", tmp_path / "checkout" / "tools", ignore=shutil.ignore_patterns("__pycache__"))
    programs = tmp_path / "bin"
    programs.mkdir()
    for tool in TOOLS:
        (programs / tool).symlink_to(str(shutil.which(tool)))
    write(programs / "dpkg-query", "exit 0")
    write(programs / "apt-get", "echo 'E: Unable to fetch some archives'; exit 100")
    return tmp_path


def write(path: Path, text: str) -> None:
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


def set_up(bare: Path, user: int) -> subprocess.CompletedProcess:
    write(bare / "bin" / "id", f"echo {user}")
    environment: Dict[str, str] = {"PATH": str(bare / "bin"), "HOME": str(bare)}
    return run(["/bin/bash", str(bare / "checkout" / "tools" / "setup.sh")], env=environment)


def test_a_failed_step_names_itself_and_its_log(bare: Path) -> None:
    ended = set_up(bare, 0)
    log = bare / "checkout" / "log" / "apt-update.log"
    assert ended.returncode == 100
    assert 'FAILED: step "apt-update" ended with exit code 100' in ended.stderr
    assert str(log) in ended.stderr
    assert "E: Unable to fetch some archives" in ended.stderr
    assert "E: Unable to fetch some archives" in log.read_text()


def test_missing_packages_that_may_not_be_installed_are_named_with_the_remedy(bare: Path) -> None:
    ended = set_up(bare, 1000)
    assert ended.returncode != 0
    packages = [
        line for line in (ROOT / "tools" / "debian-packages.txt").read_text().split("\n") if line[:1] not in "#"
    ]
    assert "Debian packages are missing and installing them needs root or sudo; as root run:" in ended.stderr
    assert "apt-get install --no-install-recommends " in ended.stderr
    for package in packages:
        assert package in ended.stderr


def test_a_system_without_apt_is_told_what_this_needs(bare: Path) -> None:
    (bare / "bin" / "apt-get").unlink()
    ended = set_up(bare, 0)
    assert ended.returncode == 1
    assert "setup: this needs Debian 12" in ended.stderr
