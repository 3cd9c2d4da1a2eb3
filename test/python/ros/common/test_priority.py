"""A program's own scheduling priority, within its session and of it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from yarm.ros.common.priority import SESSION, set_priority

ROOT = Path(__file__).resolve().parents[4]
TELL = "import os, pathlib, sys; print(os.getpriority(os.PRIO_PROCESS, 0), pathlib.Path(sys.argv[1]).read_text())"


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
