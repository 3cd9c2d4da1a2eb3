"""The supervisor with real processes: kills, signals that are handed on, nobody left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from yarm.safety.kept import KEPT, Kept, made

ROOT = Path(__file__).resolve().parents[3]
SUPERVISE = [sys.executable, str(ROOT / "scripts" / "supervise")]
LIMIT_S = 60.0
LIVES = """
import os, pathlib, sys, time
book = pathlib.Path(sys.argv[1])
with book.open("a") as out:
    out.write(f"{os.getpid()} {os.environ.get('YARM_RESTARTS', '')} {os.environ.get('YARM_LAST_END', '')}\\n")
time.sleep(1000)
"""


@pytest.fixture(name="book")
def fixture_book(tmp_path):
    return tmp_path / "book"


def started(*program):
    return subprocess.Popen([*SUPERVISE, *program], stderr=subprocess.PIPE, text=True)


def entry(book, number):
    """What the program wrote at its start of this number, from 0: pid, restarts, how it ended before."""
    until = time.monotonic() + LIMIT_S
    while time.monotonic() < until:
        lines = book.read_text().splitlines() if book.exists() else []
        if len(lines) > number:
            pid, restarts, last = lines[number].split(" ", 2)
            return int(pid), restarts, last
        time.sleep(0.01)
    raise AssertionError(f"no start {number} within {LIMIT_S} s")


def ended(process):
    return process.communicate(timeout=LIMIT_S)[1]


def gone(pid):
    until = time.monotonic() + LIMIT_S
    while time.monotonic() < until:
        if not psutil.pid_exists(pid) or psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
            return True
        time.sleep(0.01)
    return False


def test_a_killed_program_comes_back_and_is_told_why(book):
    supervisor = started(sys.executable, "-c", LIVES, str(book), "__name:=robot_driver")
    first, restarts, _ = entry(book, 0)
    assert restarts == ""
    os.kill(first, signal.SIGKILL)
    second, restarts, last = entry(book, 1)
    assert (restarts, last) == ("1", "killed by SIGKILL")
    supervisor.send_signal(signal.SIGINT)
    said = ended(supervisor)
    assert "robot_driver: killed by SIGKILL; started again in 0.1 s" in said
    assert gone(second)
    assert len(book.read_text().splitlines()) == 2


def test_a_program_dies_with_its_supervisor(book):
    supervisor = started(sys.executable, "-c", LIVES, str(book))
    child = entry(book, 0)[0]
    supervisor.kill()
    ended(supervisor)
    assert gone(child)


@pytest.mark.parametrize("code", [0, 3])
def test_an_exit_code_at_the_start_is_handed_on_and_nothing_is_tried_again(code):
    supervisor = started(sys.executable, "-c", f"raise SystemExit({code})")
    said = ended(supervisor)
    assert supervisor.returncode == code
    assert ("refuses to run" in said) is (code != 0)


def test_a_verdict_is_handed_on_without_a_word_and_a_killed_judge_comes_back(book):
    supervisor = started(
        "--verdict", sys.executable, "-c", f"{LIVES.replace('1000', '0.1')}\nraise SystemExit(1)", str(book)
    )
    said = ended(supervisor)
    assert (supervisor.returncode, said, len(book.read_text().splitlines())) == (1, "", 1)
    supervisor = started("--verdict", sys.executable, "-c", LIVES, str(book))
    os.kill(entry(book, 1)[0], signal.SIGKILL)
    assert entry(book, 2)[1:] == ("1", "killed by SIGKILL")
    supervisor.send_signal(signal.SIGINT)
    ended(supervisor)


def test_a_supervisor_without_a_program_says_how_it_is_called():
    supervisor = started("--verdict")
    assert "usage: supervise [--verdict] PROGRAM" in ended(supervisor)
    assert supervisor.returncode == 2


def test_a_program_that_is_not_there_is_named():
    supervisor = started("/nowhere/at_all")
    assert "/nowhere/at_all cannot be started" in ended(supervisor)
    assert supervisor.returncode == 2


BEATS = """
import os, pathlib, sys, time
sys.path.insert(0, sys.argv[2])
from yarm.safety.pulse import Pulse
book, pulse, number = pathlib.Path(sys.argv[1]), Pulse(), os.environ.get("YARM_RESTARTS", "")
pulse.beat()
with book.open("a") as out:
    out.write(f"{os.getpid()} {number} {os.environ.get('YARM_LAST_END', '')}\\n")
for beat in range(10**9):
    if number or beat < 20:
        pulse.beat()
    time.sleep(0.1)
"""
WATCHED = """
import sys
sys.path.insert(0, sys.argv[1])
from yarm.safety.supervise import Supervisor
raise SystemExit(Supervisor(sys.argv[2:], named_s=0.8, hangs_s=2.5).run())
"""


def watched(*program):
    source = str(ROOT / "src")
    command = [sys.executable, "-c", WATCHED, source, *program]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


def test_a_program_that_shows_no_life_any_more_is_named_and_replaced(book):
    supervisor = watched(sys.executable, "-c", BEATS, str(book), str(ROOT / "src"), "__name:=robot_driver")
    first = entry(book, 0)[0]
    second, restarts, last = entry(book, 1)
    assert (restarts, last) == ("1", "hung, without a sign of life for 2.5 s")
    assert gone(first)
    supervisor.send_signal(signal.SIGINT)
    said = ended(supervisor)
    assert "robot_driver: no sign of life for 0.8 s; is started again after 2.5 s" in said
    assert "robot_driver: hung, without a sign of life for 2.5 s; started again" in said
    assert gone(second)


def test_a_program_that_is_stopped_is_replaced_too(book):
    supervisor = watched(sys.executable, "-c", BEATS, str(book), str(ROOT / "src"))
    first = entry(book, 0)[0]
    os.kill(first, signal.SIGSTOP)
    assert entry(book, 1)[2].startswith("hung")
    supervisor.send_signal(signal.SIGINT)
    ended(supervisor)
    assert gone(first)


def test_a_program_that_never_gave_a_sign_is_left_alone(book):
    supervisor = watched(sys.executable, "-c", LIVES, str(book))
    entry(book, 0)
    with pytest.raises(subprocess.TimeoutExpired):
        supervisor.wait(4.0)
    supervisor.send_signal(signal.SIGINT)
    assert "sign of life" not in ended(supervisor)
    assert len(book.read_text().splitlines()) == 1


KEEPS = """
import os, pathlib, sys, time
from yarm.safety.kept import Kept
kept = Kept()
words = kept.words()
kept.keep({"token": "x" * 300 if not words else words["token"][:7], "port": "8470"})
with pathlib.Path(sys.argv[1]).open("a") as out:
    out.write(f"{os.getpid()} {words.get('token', '')} {words}\\n")
time.sleep(1000)
"""


def test_what_a_program_keeps_is_there_for_the_next_one(book):
    supervisor = started(sys.executable, "-c", KEEPS, str(book))
    found = []
    for number in range(3):
        pid, token, words = entry(book, number)
        found.append((token, words))
        os.kill(pid, signal.SIGKILL)
    supervisor.send_signal(signal.SIGINT)
    ended(supervisor)
    assert found[0] == ("", "{}")
    assert found[1][0] == "x" * 300
    assert found[2] == ("x" * 7, str({"token": "x" * 7, "port": "8470"}))


def test_without_a_supervisor_nothing_is_kept(monkeypatch):
    monkeypatch.delenv(KEPT, raising=False)
    kept = Kept()
    kept.keep({"token": "x"})
    assert kept.words() == {}


@pytest.mark.parametrize("data", [b"", b"{", b"[1]", b"\xff"])
def test_words_that_cannot_be_read_are_none(data, monkeypatch):
    file = made()
    try:
        monkeypatch.setenv(KEPT, str(file))
        os.pwrite(file, data, 0)
        assert Kept().words() == {}
    finally:
        os.close(file)
