"""A program's own scheduling priority, within its session and of it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from yarm.ros.common.priority import SESSION, lower, set_priority

ROOT = Path(__file__).resolve().parents[4]
TELL = "import os, pathlib, sys; print(os.getpriority(os.PRIO_PROCESS, 0), pathlib.Path(sys.argv[1]).read_text())"


ASIDE = """
import os, signal, sys
from yarm.experiments.study.processes import copies
from yarm.ros.common.priority import SESSION, in_own_session

def told():
    return os.getpriority(os.PRIO_PROCESS, 0), SESSION.read_text().split()[-1] if SESSION.exists() else ""

def work():
    print(os.getsid(0) == os.getpid(), *told(), flush=True)
    if "wait" in sys.argv:
        with copies(2) as pool:
            print(os.getpid(), *{*pool.map(slow_pid, range(8))}, flush=True)
            signal.pause()
    if "raise" in sys.argv:
        raise ValueError("told")
    return 7

def slow_pid(_):
    signal.sigtimedwait([], 0.05)
    return os.getpid()

before = told()
code = in_own_session(19, work)
print(told() == before, flush=True)
sys.exit(code)
"""


def aside(*words):
    """A program whose work is done in a session of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", ASIDE, *words],
        env={**os.environ, "PYTHONPATH": f"{ROOT / 'src'}:{os.environ.get('PYTHONPATH', '')}"},
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def run(nice, *command):
    """A program in a session of its own, as roslaunch starts it."""
    return subprocess.run(
        [sys.executable, str(ROOT / "scripts" / "at_priority"), nice, *command],
        env={**os.environ, "PYTHONPATH": f"{ROOT / 'src'}:{os.environ.get('PYTHONPATH', '')}"},
        start_new_session=True,
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )


@pytest.mark.skipif(not SESSION.exists(), reason="this kernel does not share the processors by sessions")
def test_process_and_session_get_the_priority():
    done = run("7", sys.executable, "-c", TELL, str(SESSION))
    assert done.returncode == 0, done.stderr
    process, session = done.stdout.split(maxsplit=1)
    assert int(process) == 7
    assert session.strip().endswith("nice 7")


def test_the_program_gets_its_arguments_and_its_exit_code_is_kept(tmp_path):
    done = run("0", sys.executable, "-c", "import sys; print(sys.argv[1:]); sys.exit(3)", "a b", "c")
    assert (done.returncode, done.stdout.strip()) == (3, "['a b', 'c']")


def test_what_is_refused_is_named_and_the_rest_is_done(tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    session = tmp_path / "autogroup"
    session.write_text("")
    monkeypatch.setattr(os, "setpriority", refuse)
    assert set_priority(-10, session) == ["nice value -10 of the process: Permission denied"]
    assert session.read_text() == "-10\n"
    assert set_priority(-10, tmp_path / "none") == ["nice value -10 of the process: Permission denied"]
    assert len(set_priority(-10, tmp_path)) == 2


def test_work_in_a_session_of_its_own_leaves_the_callers_priority_as_it_was():
    with aside() as program:
        out, errors = program.communicate(timeout=60.0)
    assert (program.returncode, errors) == (7, "")
    inside, outside = out.splitlines()
    assert inside.split() == ["True", "19", *(["19"] if SESSION.exists() else [])]
    assert outside == "True"


def test_work_that_raises_says_why_and_comes_to_nothing_else():
    with aside("raise") as program:
        out, errors = program.communicate(timeout=60.0)
    assert program.returncode == 1 and "ValueError: told" in errors
    assert out.splitlines()[1:] == ["True"]


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)])
def test_the_work_and_its_copies_end_with_who_asked_for_it(number, code):
    with aside("wait") as program:
        program.stdout.readline()
        pids = [int(word) for word in program.stdout.readline().split()]
        assert len(pids) == 3 and all(Path(f"/proc/{pid}").exists() for pid in pids)
        program.send_signal(number)
        assert program.wait(60.0) == code
        until_s = time.monotonic() + 60.0
        while any(running(pid) for pid in pids) and time.monotonic() < until_s:
            time.sleep(0.02)
        assert [pid for pid in pids if running(pid)] == []


def running(pid):
    """Whether a process is there, and more than an entry that nobody has taken away yet."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_another_process_is_lowered_with_its_session():
    """As ``run_experiment --nice`` does with every node, each of which roslaunch has given a session of its own."""
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, start_new_session=True) as child:
        lower(child.pid, 17)
        assert os.getpriority(os.PRIO_PROCESS, child.pid) == 17
        session = Path(f"/proc/{child.pid}/autogroup")
        assert not session.exists() or "nice 17" in session.read_text()
        child.kill()
        child.wait()
    with pytest.raises(OSError):
        lower(child.pid, 17)
