"""The page beside an experiment: its token is for the person at the terminal alone."""

from __future__ import annotations

import re
import socket
import stat
from pathlib import Path

from yarm.console.access import read_token
from yarm.ros.experiment.page import HOST, page, page_port


def test_without_a_page_nothing_is_asked_for(capsys):
    with page(False) as arguments:
        assert arguments == []
    assert capsys.readouterr().out == ""


def test_the_token_is_printed_and_handed_on_in_a_file_that_goes(capsys):
    with page(True) as arguments:
        values = dict(word.split(":=") for word in arguments)
        file = Path(values["console_token"])
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        token = read_token(file)
        printed = capsys.readouterr().out
        assert re.search(rf"http://127\.0\.0\.1:{values['console_port']}/#token={token}\n", printed)
        assert not any(token in word for word in arguments)
    assert not file.exists()


def test_a_port_that_is_taken_is_left_to_who_has_it():
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert page_port(port) not in (port, 0)
    assert page_port(port) == port
