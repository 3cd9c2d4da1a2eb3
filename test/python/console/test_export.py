"""An exported run: one file with everything in it, that asks for nothing and can be harmed by no name in it."""

from __future__ import annotations

import base64
import json
import re

from support.films import taken
from yarm.console.export import offline_page, pictures_of
from yarm.console.film import unpack
from yarm.resources import resource

EVIL = "</script><img src=x onerror=alert(1)>"


def page(title="a run", **more):
    return offline_page(resource("web"), taken(30), title, {"success": True, **more}, {"map.png": b"picture"})


def script(text, opening):
    return text.partition(opening)[2].partition("</script>")[0]


def test_every_module_is_in_it_by_a_name_and_none_by_a_path():
    imports = json.loads(script(page(), '<script type="importmap">'))["imports"]
    assert {"three", "yarm/main.js", "yarm/wire.js", "yarm/vendor/three/three.core.js"} <= set(imports)
    for name, address in imports.items():
        source = re.sub(r"/\*.*?\*/", "", base64.b64decode(address.partition("base64,")[2]).decode(), flags=re.S)
        asked = re.findall(r"""^\s*(?:import|export)\b[^;'"]*?from\s*['"]([^'"]+)['"]""", source, re.M)
        asked += re.findall(r"""\}\s*from\s*['"]([^'"]+)['"]""", source)
        assert set(asked) <= set(imports), name


def test_it_asks_for_nothing():
    text = page()
    outside = re.sub(r"<script.*?</script>|<style.*?</style>", "", text, flags=re.S)
    assert "src=" not in outside
    assert "<link" not in text
    assert "default-src 'none'" in text


def test_the_film_and_the_pictures_are_in_it():
    brought = json.loads(script(page(), '<script type="application/json" id="offline">'))
    blocks = [list(unpack(base64.b64decode(block))) for block in brought["film"]["data"]]
    assert len(blocks) == len(brought["film"]["blocks"]) == 3
    assert brought["run"]["summary"] == {"success": True}
    assert base64.b64decode(brought["files"]["map.png"].partition("base64,")[2]) == b"picture"


def test_a_name_cannot_end_the_script_it_stands_in():
    text = page(EVIL, reason=EVIL)
    assert EVIL not in text
    brought = json.loads(script(text, '<script type="application/json" id="offline">'))
    assert brought["run"]["run"] == brought["run"]["summary"]["reason"] == EVIL


def test_pictures_are_the_png_files_of_a_folder(tmp_path):
    (tmp_path / "a.png").write_bytes(b"a")
    (tmp_path / "b.csv").write_bytes(b"b")
    assert pictures_of(tmp_path) == {"a.png": b"a"}
