"""The make commands say in one message what is wrong, name it and the remedy, and end with a non-zero exit code."""

from __future__ import annotations

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
    assert "unknown variable COLOUR: make knows CASE SEED TESTS; see `make help`" in ended.stderr


def test_a_known_variable_may_hold_several_words() -> None:
    ended = run(["make", "-n", "-C", str(ROOT), "--no-print-directory", "test", "TESTS=-k name --maxfail=2"])
    assert ended.returncode == 0, ended.stderr
    assert "pytest test -k name --maxfail=2" in ended.stdout


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
