"""A port that is found free is still free when a server is started on it, whatever others open meanwhile."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from yarm.ros.experiment import ports
from yarm.ros.experiment.ports import ANY, HOST, LOWEST, any_ports, free_port, is_free


def test_it_is_free_and_none_that_the_system_gives_to_others() -> None:
    first, last = any_ports()
    for _ in range(50):
        port = free_port()
        assert LOWEST <= port < 65536 and not first <= port <= last
        assert is_free(port)


def test_one_that_somebody_listens_on_is_not() -> None:
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        assert not is_free(taken.getsockname()[1])


def test_where_nobody_says_which_are_given_the_usual_ones_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ports, "ANY_FROM", tmp_path / "missing")
    assert any_ports() == ANY
    (tmp_path / "faulty").write_text("all\n")
    monkeypatch.setattr(ports, "ANY_FROM", tmp_path / "faulty")
    assert any_ports() == ANY


def test_where_the_system_gives_all_of_them_it_is_one_of_those(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ports, "ANY_FROM", tmp_path / "all")
    (tmp_path / "all").write_text("1024\t65535\n")
    port = free_port()
    assert 1024 <= port < 65536 and is_free(port)
