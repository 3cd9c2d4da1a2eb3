"""A pass of the explorer's loop: what it says of itself."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from unittest.mock import MagicMock

from yarm.ros.exploration import node
from yarm.ros.exploration.node import ExplorerNode


def passed(monkeypatch):
    clock = iter((7.0, 7.005))
    monkeypatch.setattr(node.time, "thread_time", lambda: next(clock))
    made = ExplorerNode.__new__(ExplorerNode)
    made._session_lock, made._session, made._saver = threading.Lock(), MagicMock(), MagicMock()
    made._inputs, made._outputs = MagicMock(), MagicMock()
    made._session.step.return_value = SimpleNamespace(saves=(), events=(), complaints=("scan",))
    made._inputs.complaints.return_value = ("depth camera",)
    made._pass(1.0)
    return made._outputs


def test_what_a_pass_took_is_processor_time_of_the_loop(monkeypatch):
    ((ms,), _) = passed(monkeypatch).took.call_args
    assert abs(ms - 5.0) < 1e-9


def test_the_status_bears_what_the_session_and_what_the_inputs_complain_of(monkeypatch):
    assert passed(monkeypatch).status.call_args[0][-1] == ("scan", "depth camera")
