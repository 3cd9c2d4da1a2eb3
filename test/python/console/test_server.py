"""What a page can have done: commands that reach the cell as they were given, or not at all."""

from __future__ import annotations

import asyncio
import time

import pytest

from support.console_stand import OWN, Stand, run, told
from yarm.commander.requests import Request

NEXT = {"next_state": True}


@pytest.fixture
def stand(tmp_path):
    return Stand(tmp_path)


@pytest.mark.parametrize(
    ("body", "request_"),
    [
        (NEXT, Request(next_state=True)),
        ({"current_state": True}, Request(current_state=True)),
        ({"previous_state": True}, Request(previous_state=True)),
        ({"jump_state": 5}, Request(jump_state=5)),
        ({}, Request()),
    ],
)
def test_a_change_of_state_reaches_the_cell_as_it_was_given(stand, body, request_):
    async def ask():
        async with stand.open() as client:
            assert (await client.post("/command/state", json=body, headers=OWN)).status == 200

    run(ask())
    assert stand.cell.calls == [("state", request_)]
    assert any(line.startswith("command state") for line in stand.said), "commands are logged"


@pytest.mark.parametrize(
    ("name", "body", "words"),
    [
        ("state", {"next_state": 1}, "wrong type: 'next_state'"),
        ("state", {"jump_state": True}, "wrong type: 'jump_state'"),
        ("state", {"do": "it"}, "known fields: next_state (bool)"),
        ("state", [], "must be an object"),
        ("release", {"confirm": 3}, "wrong type"),
        ("fly", {}, "there are check, state, stop, release"),
    ],
)
def test_commands_that_mean_nothing_are_refused(stand, name, body, words):
    async def command():
        async with stand.open() as client:
            status, message = await told(await client.post(f"/command/{name}", json=body, headers=OWN))
            assert status in (400, 404)
            assert words in message

    run(command())
    assert stand.cell.calls == []


def test_a_stop_stops_whatever_else_its_message_says(stand):
    async def stop():
        async with stand.open() as client:
            headers = {**OWN, "Content-Type": "application/json"}
            answers = [await client.post("/command/stop", data=data, headers=headers) for data in ("{", "[1]", "")]
            assert [answer.status for answer in answers] == [200] * 3

    run(stop())
    assert stand.cell.calls == [("stop",)] * 3


def test_a_release_needs_a_second_step_soon(stand, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])

    async def release():
        async with stand.open() as client:

            async def ask(body):
                now[0] += 1.0
                answer = await client.post("/command/release", json=body, headers=OWN)
                return answer.status, await answer.json()

            status, first = await ask({})
            assert status == 200
            assert stand.cell.calls == []
            assert (await ask({"confirm": "guess"}))[0] == 409
            assert (await ask({"confirm": first["confirm"]}))[0] == 409, "one try only"
            _, late = await ask({})
            now[0] += 11.0
            assert (await ask({"confirm": late["confirm"]}))[0] == 409
            _, before = await ask({})
            await client.post("/command/stop", json={}, headers=OWN)
            assert (await ask({"confirm": before["confirm"]}))[0] == 409, "a stop between them counts"
            _, good = await ask({})
            assert (await ask({"confirm": good["confirm"]}))[0] == 200

    asyncio.run(release())
    assert stand.cell.calls == [("stop",), ("release",)]


def test_a_cell_that_does_not_answer_is_told(tmp_path):
    stand = Stand(tmp_path, answer_s=0.5)
    stand.cell.gate.clear()

    async def ask():
        async with stand.open() as client:
            status, message = await told(await client.post("/command/state", json=NEXT, headers=OWN))
            assert status == 504
            assert "no answer from the cell within 0.5 s" in message
            stand.cell.gate.set()

    run(ask())
