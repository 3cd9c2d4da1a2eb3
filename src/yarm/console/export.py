"""One run as a single HTML file that opens without this program, and without a network."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any, Dict, List, Mapping

from yarm.console.film import Film
from yarm.console.results import PICTURE

ENTRY, STYLE, PAGE = "main.js", "style.css", "index.html"
OWN = "yarm/"
IMPORT = re.compile(r"""((?:^|;|\})\s*(?:import|export)\b[^'";]*?from\s*|^import\s*)(['"])(\.{1,2}/[^'"]+)\2""", re.M)
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; img-src data:; "
    "base-uri 'none'; form-action 'none'"
)
"""The file may run what it brings, and load nothing."""


def offline_page(root: Path, film: Film, title: str, summary: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    """The whole file.

    Args:
        root: folder of the page.
        film: what is played.
        title: of the run, for people.
        summary: what came of it; empty when nobody knows.
        pictures: contents of the run's PNG files, by their names.

    Raises:
        OSError: the page's own files cannot be read.
    """
    brought = {
        "film": film.as_text(),
        "run": {"run": title, "summary": dict(summary), "files": sorted(pictures)},
        "files": {name: _address("image/png", data) for name, data in pictures.items()},
    }
    page = (root / PAGE).read_text(encoding="utf-8")
    modules = {"three": "vendor/three/three.module.js"}
    sources = _modules(root, ENTRY) | _modules(root, modules["three"])
    imports = {_name(path): _address("text/javascript", text.encode()) for path, text in sources.items()}
    imports |= {name: imports[_name(path)] for name, path in modules.items()}
    style = (root / STYLE).read_text(encoding="utf-8")
    head = [
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
        f"<style>{style}</style>",
        f'<script type="importmap">{_harmless({"imports": imports})}</script>',
        f'<script type="application/json" id="offline">{_harmless(brought)}</script>',
        f'<script type="module">import "{_name(ENTRY)}";</script>',
    ]
    kept = re.sub(r"<link [^>]*>\n?|<script\b.*?</script>\n?", "", page, flags=re.S)
    before, _, after = kept.partition("</head>")
    return before + "\n".join(head) + "\n</head>" + after


def pictures_of(folder: Path) -> Dict[str, bytes]:
    """The PNG files of a run's folder, by their names.

    Raises:
        OSError: they cannot be read.
    """
    return {path.name: path.read_bytes() for path in sorted(folder.glob(f"*{PICTURE}")) if path.is_file()}


def _modules(root: Path, entry: str) -> Dict[str, str]:
    """Sources of a module and all that it imports, by their paths; relative imports in them become names."""
    found: Dict[str, str] = {}
    left: List[str] = [entry]
    while left:
        path = left.pop()
        if path in found:
            continue
        here = (root / path).parent

        def named(match: re.Match[str], here: Path = here) -> str:
            target = (here / match.group(3)).resolve().relative_to(root.resolve()).as_posix()
            left.append(target)
            return f"{match.group(1)}{match.group(2)}{_name(target)}{match.group(2)}"

        found[path] = IMPORT.sub(named, (root / path).read_text(encoding="utf-8"))
    return found


def _name(path: str) -> str:
    return f"{OWN}{path}"


def _address(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


def _harmless(words: Any) -> str:
    """JSON in which nothing can end the script it stands in."""
    return json.dumps(words, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
