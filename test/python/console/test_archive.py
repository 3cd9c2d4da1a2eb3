"""What a page is given of the past: the film of the last minutes, recorded runs, results; and nothing besides."""

from __future__ import annotations

import asyncio
import json
import time

import pytest

from support.console_stand import OWN, Stand, run, told
from support.films import shown, taken
from yarm.console.film import Film, unpack
from yarm.console.wire import decode

LIMIT_S = 20.0


@pytest.fixture
def root(tmp_path):
    folder = tmp_path / "results/2m1ma/3"
    folder.mkdir(parents=True)
    (folder / "summary.yaml").write_text("case: 2m1ma\nsuccess: true\nfaults: []\n")
    (folder / "map.png").write_bytes(b"png")
    (folder / "proof.html").write_text("<script>1</script>")
    taken(30).write(folder / "run.film")
    return tmp_path


async def whole(client, base=""):
    """Index and blocks of a film, as a page asks for them."""
    index = await (await client.get(f"{base}/film")).json()
    blocks = []
    for i in range(len(index["blocks"])):
        answer = await client.get(f"{base}/film/{index['first'] + i}")
        assert answer.status == 200
        blocks.append(list(unpack(await answer.read())))
    return index, blocks


def test_a_running_system_is_filmed_though_nobody_looks(tmp_path):
    stand = Stand(tmp_path, film_s=60.0, film_hz=10.0)

    async def look():
        async with stand.open() as client:
            until_s = time.monotonic() + LIMIT_S
            while not (await (await client.get("/film")).json())["blocks"]:
                assert time.monotonic() < until_s
                await asyncio.sleep(0.05)
            _, blocks = await whole(client)
            return [decode(message)[0]["kind"] for block in blocks for _, message in block]

    kinds = run(look())
    assert kinds[0] == "scene"
    assert "state" in kinds


def test_without_a_film_nothing_is_drawn_unseen(tmp_path):
    stand = Stand(tmp_path)

    async def wait():
        async with stand.open() as client:
            await asyncio.sleep(0.3)
            return await told(await client.get("/film"))

    assert run(wait()) == (404, "no film is kept here")
    assert stand.view.made == 0


def test_a_recorded_run_is_played_and_takes_no_commands(tmp_path):
    film = taken(30)
    stand = Stand(tmp_path, film=film)

    async def look():
        async with stand.open() as client:
            about = await (await client.get("/about")).json()
            assert about == {"live": False, "title": "a run"}
            index, blocks = await whole(client)
            assert index == json.loads(json.dumps(film.index()))
            assert [[time_s for time_s, _ in block] for block in blocks] == [
                [time_s for time_s, _ in block] for block in shown(film)
            ]
            for command in ("stop", "release", "state"):
                status, message = await told(await client.post(f"/command/{command}", json={}, headers=OWN))
                assert (status, message) == (409, "this is a recorded run: nothing can be asked of it")
            assert (await client.post("/ask/why", json={"subject": "a"})).status == 409
            assert (await client.get("/live")).status == 404

    run(look())
    assert stand.cell.calls == []


def test_results_are_listed_and_one_is_told_and_played(root):
    async def look():
        async with Stand(root).open() as client:
            assert (await (await client.get("/about")).json())["live"] is True
            (row,) = (await (await client.get("/results")).json())["runs"]
            assert (row["run"], row["success"], row["film"]) == ("2m1ma/3", True, True)
            told_ = await (await client.get("/results/2m1ma/3/summary")).json()
            assert told_["files"] == ["map.png", "proof.html"]
            picture = await client.get("/results/2m1ma/3/file/map.png")
            assert (picture.content_type, await picture.read()) == ("image/png", b"png")
            _, blocks = await whole(client, "/results/2m1ma/3")
            assert len(blocks) == len(Film.read(root / "results/2m1ma/3/run.film").index()["blocks"])

    run(look())


def test_a_proof_sheet_may_show_what_it_brings_and_reach_nothing(root):
    async def look():
        async with Stand(root).open() as client:
            return (await client.get("/results/2m1ma/3/file/proof.html")).headers["Content-Security-Policy"]

    policy = run(look())
    assert policy.startswith("sandbox allow-scripts; default-src 'none'")
    assert "connect-src" not in policy
    assert "allow-same-origin" not in policy


@pytest.mark.parametrize(
    "path",
    [
        "/film/99",
        "/film/x",
        "/results/2m1ma/4/summary",
        "/results/2m1ma/3/file/summary.yaml",
        "/results/2m1ma/3/file/..%2f..%2f..%2fsecret.js",
        "/results/..%2f..%2f2m1ma/3/summary",
        "/results/2m1ma/3/film/99",
        "/results/2m1ma/film",
    ],
)
def test_what_is_not_there_is_refused(root, path):
    async def look():
        async with Stand(root, film_s=60.0).open() as client:
            status, message = await told(await client.get(path))
            assert status == 404
            assert message

    run(look())


def test_a_broken_film_is_told(root):
    (root / "results/2m1ma/3/run.film").write_bytes(b"nothing")

    async def look():
        async with Stand(root).open() as client:
            return await told(await client.get("/results/2m1ma/3/film"))

    status, message = run(look())
    assert status == 404
    assert "is no film that can be shown" in message


def test_on_another_address_the_past_needs_the_token_too(root):
    async def look():
        async with Stand(root, host="0.0.0.0").open() as client:
            for path in ("/film", "/results", "/results/2m1ma/3/summary", "/about"):
                assert (await client.get(path)).status == 401
                assert (await client.get(path, headers=OWN)).status in (200, 404)

    run(look())
