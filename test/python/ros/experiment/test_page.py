"""The page beside an experiment: its token is for the person at the terminal alone."""

from __future__ import annotations

import socket
import stat
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from yarm.console.access import read_token
from yarm.console.results import FILM
from yarm.ros.experiment.page import HOST, look_back, page, page_port


def test_without_a_page_nothing_is_asked_for(tmp_path, capsys):
    with page(False, tmp_path) as arguments:
        assert arguments == []
    assert capsys.readouterr().out == ""


def test_the_token_is_printed_when_the_page_answers_and_handed_on_in_a_file_that_goes(tmp_path, capsys):
    with page(True, tmp_path) as arguments:
        values = dict(word.split(":=") for word in arguments)
        assert values["console_results"] == str(tmp_path)
        file = Path(values["console_token"])
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        token = read_token(file)
        said = capsys.readouterr().out
        assert "http" not in said, "nobody listens there yet"
        with socket.create_server((HOST, int(values["console_port"]))):
            said = until_said(capsys, "#token=")
        assert said == f"console: http://127.0.0.1:{values['console_port']}/#token={token}\n"
        assert not any(token in word for word in arguments)
    assert not file.exists()


def until_said(capsys, words, limit_s=30.0):
    """What is printed until some words are."""
    said, until_s = "", time.monotonic() + limit_s
    while words not in said:
        assert time.monotonic() < until_s, said
        time.sleep(0.02)
        said += capsys.readouterr().out
    return said


@pytest.fixture(name="played")
def played_fixture(monkeypatch):
    """Calls of programs, which are not made; and a person at the terminal."""
    calls = []
    monkeypatch.setattr("subprocess.run", lambda call, check: calls.append(call))
    monkeypatch.setattr("sys.stdin", SimpleNamespace(isatty=lambda: True))
    return calls


def test_afterwards_the_run_is_played_on_the_same_port_for_who_sits_at_the_terminal(played, tmp_path, monkeypatch):
    arguments = ["console:=true", "console_port:=8470", "console_token:=/tmp/token"]
    look_back(tmp_path, arguments)
    assert played == [], "there is no film"
    (tmp_path / FILM).write_bytes(b"film")
    look_back(tmp_path, [])
    assert played == [], "there was no page"
    look_back(tmp_path, arguments)
    assert played == [["rosrun", "yarm", "console", "--run", str(tmp_path), "--port", "8470"]]
    monkeypatch.setattr("sys.stdin", SimpleNamespace(isatty=lambda: False))
    look_back(tmp_path, arguments)
    assert len(played) == 1, "nobody is there to end it"


def test_a_port_that_is_taken_is_left_to_who_has_it():
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert page_port(port) not in (port, 0)
    assert page_port(port) == port
