"""Every sentence about access to the console, by a client that means it ill (docs/security.md)."""

from __future__ import annotations

import asyncio

import pytest
from aiohttp import ClientSession, WSMsgType

from support.console_stand import OWN, TOKEN, Stand, run, told
from yarm.console import guard
from yarm.console.access import (
    FORGIVEN_S,
    LONGEST_WAIT_S,
    TOLD,
    TokenError,
    TokenGate,
    host_fault,
    is_loopback,
    new_token,
    origin_fault,
    read_token,
)
from yarm.console.guard import BODY_BYTES, COMMANDS, REQUESTS, WAITING
from yarm.console.pages import AHEAD, MESSAGE_BYTES, MESSAGES, MOST_PAGES, POLICY
from yarm.console.params import ConsoleParams
from yarm.console.wire import decode

EVIL = {"Origin": "http://evil.example"}
NEXT = {"next_state": True}


@pytest.fixture
def stand(tmp_path):
    return Stand(tmp_path)


def test_it_listens_on_loopback_unless_told_otherwise():
    assert is_loopback(ConsoleParams().host)
    assert [is_loopback(host) for host in ("::1", "localhost", "127.3.2.1")] == [True] * 3
    assert [is_loopback(host) for host in ("0.0.0.0", "::", "192.168.0.7", "cell.example")] == [False] * 4


def test_looking_needs_nothing_on_loopback(stand):
    async def look():
        async with stand.open() as client:
            assert (await client.get("/")).status == 200
            assert (await client.get("/main.js")).status == 200
            async with client.ws_connect("/live") as socket:
                kinds = [decode(await socket.receive_bytes())[0]["kind"] for _ in range(2)]
            assert kinds == ["scene", "state"]
            assert (await client.post("/ask/why", json={"subject": "debris_1"})).status == 200

    run(look())
    assert stand.cell.calls == [("why", "debris_1")]


@pytest.mark.parametrize("name", ["check", "state", "stop", "release"])
@pytest.mark.parametrize(
    ("headers", "words"),
    [
        ({}, "needs the token"),
        ({"Authorization": "Bearer wrong"}, "wrong"),
        ({"Authorization": f"Bearer {TOKEN}x"}, "wrong"),
        ({"Authorization": f"Basic {TOKEN}"}, "needs the token"),
        ({"Cookie": f"yarm_console_80={TOKEN}"}, "needs the token"),
    ],
)
def test_no_command_without_the_right_token(stand, name, headers, words):
    async def command():
        async with stand.open() as client:
            status, message = await told(await client.post(f"/command/{name}", json={}, headers=headers))
            assert status == 401
            assert words in message
            query = await client.post(f"/command/{name}?token={TOKEN}", json={})
            assert query.status == 401, "a token in the address is none: addresses are written into logs"

    run(command())
    assert stand.cell.calls == []


def test_the_token_is_checked_on_every_command(stand):
    """Whoever was let in once is not let in again without it, on the same connection."""

    async def twice():
        async with stand.open() as client:
            assert (await client.post("/command/state", json=NEXT, headers=OWN)).status == 200
            assert (await client.post("/command/state", json=NEXT)).status == 401

    run(twice())
    assert len(stand.cell.calls) == 1


def test_on_another_address_everything_needs_the_token(tmp_path):
    stand = Stand(tmp_path, host="0.0.0.0")

    async def ask():
        async with stand.open() as client:
            for path in ("/", "/main.js", "/live", "/no_such"):
                assert (await client.get(path)).status == 401, path
            assert (await client.post("/ask/why", json={"subject": "a"})).status == 401
            moved = await client.get(f"/?token={TOKEN}", allow_redirects=False)
            assert moved.status == 302
            assert moved.headers["Location"] == f"/#token={TOKEN}"
            cookie = moved.headers["Set-Cookie"]
            assert "HttpOnly" in cookie
            assert "SameSite=Strict" in cookie
            assert (await client.get("/?token=wrong", allow_redirects=False)).status == 401
            cookies = {"Cookie": cookie.split(";")[0]}
            assert (await client.get("/main.js", headers=cookies)).status == 200
            async with client.ws_connect("/live", headers=cookies) as socket:
                assert decode(await socket.receive_bytes())[0]["kind"] == "scene"
            assert (await client.post("/command/stop", json={}, headers=cookies)).status == 401

    run(ask())
    assert stand.cell.calls == []


def test_a_foreign_page_may_neither_look_nor_command(stand):
    async def foreign():
        async with stand.open() as client:
            for headers in (EVIL, {"Origin": "null"}, {"Origin": f"http://127.0.0.1:{client.port + 1}"}):
                status, message = await told(await client.get("/live", headers=headers))
                assert status == 403
                assert headers["Origin"] in message
                for name in ("state", "stop", "release"):
                    answer = await client.post(f"/command/{name}", json={}, headers={**OWN, **headers})
                    assert answer.status == 403
                assert (await client.post("/ask/why", json={"subject": "a"}, headers=headers)).status == 403
            own = {"Origin": f"http://127.0.0.1:{client.port}"}
            assert (await client.post("/command/stop", json={}, headers={**OWN, **own})).status == 200

    run(foreign())
    assert stand.cell.calls == [("stop",)]
    assert any("evil.example" in line for line in stand.said)


def test_a_name_that_was_pointed_here_is_refused(stand):
    async def rebound():
        async with stand.open() as client:
            evil = {"Host": "evil.example", "Origin": "http://evil.example"}
            assert (await client.get("/", headers=evil)).status == 421
            assert (await client.post("/command/stop", json={}, headers={**OWN, **evil})).status == 421

    run(rebound())
    assert stand.cell.calls == []
    assert host_fault("127.0.0.1:8470", "127.0.0.1") == host_fault("[::1]:8470", "::1") == ""
    assert host_fault("cell.local:8470", "cell.local") == ""
    assert "evil.example" in host_fault("evil.example:8470", "127.0.0.1")
    assert host_fault("", "127.0.0.1")


def test_origins():
    assert origin_fault("", "127.0.0.1:1") == origin_fault("http://127.0.0.1:1", "127.0.0.1:1") == ""
    for foreign in (
        "http://127.0.0.1:2",
        "http://localhost:1",
        "null",
        "http://127.0.0.1:1.evil.example",
        "127.0.0.1:1",
    ):
        assert origin_fault(foreign, "127.0.0.1:1"), foreign


def test_a_form_of_a_foreign_page_is_no_command(stand):
    """A browser sends text and forms to anybody without asking first; JSON it does not."""

    async def form():
        async with stand.open() as client:
            answers = [
                await client.post("/command/stop", data="{}", headers={**OWN, "Content-Type": kind})
                for kind in ("text/plain", "application/x-www-form-urlencoded")
            ]
            assert [answer.status for answer in answers] == [415, 415]

    run(form())
    assert stand.cell.calls == []


def test_wrong_tokens_are_slowed_down_and_logged_and_never_shown(stand):
    async def guess():
        async with stand.open() as client:
            began = asyncio.get_running_loop().time()
            for number in range(3):
                answer = await client.post(
                    "/command/state", json=NEXT, headers={"Authorization": f"Bearer guess{number}"}
                )
                assert answer.status == 401
            return asyncio.get_running_loop().time() - began

    assert run(guess()) >= 0.25 + 0.5
    lines = [line for line in stand.said if "wrong token" in line]
    assert len(lines) == 3
    assert "127.0.0.1" in lines[0]
    assert not any("guess" in line or TOKEN in line for line in stand.said)


async def flooded(client, path, guesses, monkeypatch):
    """Statuses of so many guesses at once; nobody's wait ends before all others have an answer, however slow it is."""
    over, asked = asyncio.Event(), []

    async def waits(wait_s):
        asked.append(wait_s)
        await over.wait()

    monkeypatch.setattr(guard, "sleep", waits)
    jobs = [
        asyncio.ensure_future(client.post(path, json=NEXT, headers={"Authorization": f"Bearer guess{n}"}))
        for n in range(guesses)
    ]
    left = set(jobs)
    while len(left) > WAITING:
        _, left = await asyncio.wait(left, return_when=asyncio.FIRST_COMPLETED)
    over.set()
    return [answer.status for answer in await asyncio.gather(*jobs)], asked


def test_many_guesses_at_once_are_no_faster(stand, monkeypatch):
    async def flood():
        async with stand.open() as client:
            await client.post("/command/state", json=NEXT, headers={"Authorization": "Bearer guess"})
            answers, waits = await flooded(client, "/command/state", 40, monkeypatch)
            assert answers.count(401) == WAITING, "only so many are looked at"
            assert answers.count(429) == 40 - WAITING
            assert waits == [0.25] * WAITING

    run(flood())
    assert stand.cell.calls == []


def test_the_stop_works_while_others_guess_and_flood_and_the_cell_is_busy(stand):
    """Whoever holds the token stops everything, at once, whatever else is going on."""

    async def hostile(client):
        with_guess = {"Authorization": "Bearer guess"}
        jobs = [client.post("/command/state", json=NEXT, headers=with_guess) for _ in range(30)]
        jobs += [client.post("/command/stop", json={}, headers=with_guess) for _ in range(10)]
        jobs += [client.get("/main.js") for _ in range(300)]
        jobs += [client.post("/command/state", json=NEXT, headers=OWN) for _ in range(8)]
        return await asyncio.gather(*jobs, return_exceptions=True)

    async def stop():
        async with stand.open() as client:
            stand.cell.gate.clear()
            pages = [await client.ws_connect("/live") for _ in range(4)]
            flood = asyncio.ensure_future(hostile(client))
            await asyncio.sleep(0)
            async with ClientSession() as own:  # connections of its own, as another person's browser has
                answer = await own.post(client.make_url("/command/stop"), json={}, headers=OWN)
                assert answer.status == 200
            assert ("stop",) in stand.cell.calls
            assert not [call for call in stand.cell.calls if call[0] == "state"], "the others still wait"
            stand.cell.gate.set()
            await flood
            for page in pages:
                await page.close()

    run(stop())


def test_the_gate_waits_longer_each_time_and_forgives():
    now, said = [100.0], []
    gate = TokenGate("right", lambda: now[0], said.append)
    assert gate.wait_s("a") == 0.0
    waits = []
    for _ in range(8):
        assert not gate.right("a", "wrong")
        waits.append(gate.wait_s("a"))
    assert waits == [0.25, 0.5, 1.0, 2.0, 4.0, 4.0, 4.0, 4.0]
    assert waits[-1] == LONGEST_WAIT_S
    assert gate.wait_s("b") == 0.0
    assert gate.right("a", "right")
    assert gate.wait_s("a") == LONGEST_WAIT_S, "a right token between them wipes nothing out"
    now[0] += FORGIVEN_S + 1.0
    assert gate.wait_s("a") == 0.0
    assert not gate.right("a", "")
    assert len(said) == 8, "no token at all is no wrong one"
    for peer in range(1000):
        gate.right(str(peer), "wrong")
    assert len(gate._records) <= 256


def test_a_flood_of_guesses_fills_no_log(stand, monkeypatch):
    """The stop looks at each token at once; it says each of the first, and then less and less."""

    async def flood():
        async with stand.open() as client:
            answers, _ = await flooded(client, "/command/stop", 300, monkeypatch)
            assert (answers.count(401), answers.count(429)) == (WAITING, 300 - WAITING)

    run(flood())
    lines = [line for line in stand.said if "wrong token" in line]
    numbers = [int(line.split("number ")[1].split(":")[0]) for line in lines]
    assert numbers == [*range(1, TOLD + 1), 32, 64, 128, 256]
    assert stand.cell.calls == []


def test_messages_are_limited_in_size(stand):
    async def large():
        async with stand.open() as client:
            body = {"subject": "a" * BODY_BYTES}
            assert (await client.post("/ask/why", json=body)).status == 413
            assert (await client.post("/command/state", json=body, headers=OWN)).status == 413
            async with client.ws_connect("/live") as socket:
                await socket.send_str("1" * (MESSAGE_BYTES + 1))
                assert (await closed(socket)) == 1009

    run(large())
    assert stand.cell.calls == []


def test_messages_are_limited_in_rate(stand):
    async def often():
        async with stand.open() as client:
            answers = await asyncio.gather(*(client.get("/main.js") for _ in range(int(REQUESTS.burst) + 200)))
            assert 429 in [answer.status for answer in answers]
            answers = [
                (await client.post("/command/check", json={}, headers=OWN)).status
                for _ in range(int(COMMANDS.burst) + 10)
            ]
            assert answers[: int(COMMANDS.burst)] == [200] * int(COMMANDS.burst), "nor any other command"
            assert 429 in answers
            answer = await client.post("/command/stop", json={}, headers=OWN)
            assert answer.status == 200, "a flood of requests does not hold up the stop"

    run(often())


def test_a_page_that_floods_is_thrown_out(stand):
    async def flood():
        async with stand.open() as client:
            async with client.ws_connect("/live") as socket:
                for _ in range(int(MESSAGES.burst) + 100):
                    await socket.send_str("1")
                assert (await closed(socket)) == POLICY
            async with client.ws_connect("/live") as socket:
                await socket.send_str('{"command": "stop"}')
                assert (await closed(socket)) == POLICY
            async with client.ws_connect("/live") as socket:
                await socket.send_bytes(b"\0" * 8)
                assert (await closed(socket)) == POLICY

    run(flood())
    assert stand.cell.calls == []


def test_only_so_many_pages(stand):
    async def many():
        async with stand.open() as client:
            pages = [await client.ws_connect("/live") for _ in range(MOST_PAGES)]
            assert (await client.get("/live")).status == 503
            await pages.pop().close()
            for page in pages:
                await page.close()
            async with client.ws_connect("/live") as socket:
                assert await socket.receive_bytes()

    run(many())


def test_a_page_that_does_not_show_its_pictures_gets_no_more(stand):
    """Nothing piles up for it; who shows them goes on, and gets the newest."""

    async def slow():
        async with stand.open() as client, client.ws_connect("/live") as idle, client.ws_connect("/live") as quick:
            shown = 0
            while shown < 20:
                header, _ = decode(await quick.receive_bytes())
                if header["kind"] == "state":
                    shown += 1
                    await quick.send_str(str(shown))
            got = [decode(await idle.receive_bytes())[0] for _ in range(1 + AHEAD)]
            assert [header["kind"] for header in got] == ["scene"] + ["state"] * AHEAD
            with pytest.raises(asyncio.TimeoutError):
                await idle.receive(timeout=0.3)
            await idle.send_str(str(AHEAD))
            newest, _ = decode(await idle.receive_bytes())
            assert newest["made"] >= 20, "what came between is left out"

    run(slow())


def test_no_picture_is_made_for_nobody(stand):
    async def quiet():
        async with stand.open():
            await asyncio.sleep(0.3)

    run(quiet())
    assert stand.view.made == 0


@pytest.mark.parametrize(
    "path", ["/../secret.js", "/%2e%2e/secret.js", "/..%2fsecret.js", "/vendor/LICENSE", "/etc/passwd", "//etc/passwd"]
)
def test_nothing_but_the_page_can_be_had(stand, path):
    async def get():
        async with stand.open() as client:
            reader, writer = await asyncio.open_connection("127.0.0.1", client.port)
            writer.write(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n".encode())
            first = (await reader.read()).decode(errors="replace").split("\r\n")[0]
            writer.close()
            assert "404" in first

    run(get())


def test_the_page_may_load_and_call_nothing_but_its_server(stand):
    async def get():
        async with stand.open() as client:
            answer = await client.get("/")
            policy = answer.headers["Content-Security-Policy"]
            assert "default-src 'none'" in policy
            assert "frame-ancestors 'none'" in policy
            assert "unsafe" not in policy
            assert "http" not in policy
            plain = await client.get("/", headers={"Accept-Encoding": "identity"})
            assert "Content-Encoding" not in plain.headers
            assert await plain.read() == await answer.read()
            assert answer.headers["Content-Encoding"] == "gzip"
            again = await client.get("/", headers={"If-None-Match": answer.headers["ETag"]})
            assert again.status == 304

    run(get())


def test_a_token_that_is_made_is_long_and_new():
    made = {new_token() for _ in range(10)}
    assert len(made) == 10
    assert min(map(len, made)) >= 40


def test_a_token_from_a_file(tmp_path):
    path = tmp_path / "token"
    path.write_text(f"{TOKEN}\nnot this\n")
    path.chmod(0o600)
    assert read_token(path) == TOKEN


@pytest.mark.parametrize(
    ("text", "mode", "words"),
    [
        (TOKEN, 0o640, "chmod 600"),
        (TOKEN, 0o604, "mode 604"),
        ("short", 0o600, "at least 24"),
        ("", 0o600, "at least 24"),
        ("with spaces with spaces with spaces", 0o600, "letters"),
        ("é" * 30, 0o600, "ascii"),
    ],
)
def test_a_token_file_that_protects_nothing_is_refused(tmp_path, text, mode, words):
    path = tmp_path / "token"
    path.write_text(text)
    path.chmod(mode)
    with pytest.raises(TokenError, match=words):
        read_token(path)
    with pytest.raises(TokenError, match="No such file"):
        read_token(tmp_path / "none")


async def closed(socket):
    """Code with which the server closes a page; pictures that are still on their way are passed over."""
    while True:
        message = await socket.receive()
        if message.type in (WSMsgType.CLOSE, WSMsgType.CLOSED, WSMsgType.CLOSING):
            return socket.close_code
