"""The runs below a folder of results: which there are, what came of each, and the files a page may show of them."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import yaml

SUMMARY, FILM, PROOF = "summary.yaml", "run.film", "proof.html"
DEEPEST = 6
"""Folders between the root and a run's own, at most."""
MOST_RUNS = 300
"""Runs that are listed: the newest."""
PICTURE = ".png"
SHOWN = (PICTURE, ".csv", ".log")
"""Kinds of files of a run that may be looked at, besides its proof sheet."""
LARGEST_SUMMARY = 2**20
NAME = re.compile(r"[\w.\-]+")
HEADLINES = ("case", "arena", "layout", "controller", "seed", "mode", "success", "outcome", "reason")
"""What a summary says that is shown in the list of runs, with its faults."""

Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class ResultError(ValueError):
    """There is no such run, or its summary says nothing; the message names it."""


@dataclass(frozen=True)
class _Read:
    written_s: float
    row: Dict[str, Any]


class Results:
    """Reads them when they are asked for; one that has not changed is not read again. Not thread-safe."""

    def __init__(self, root: Path) -> None:
        """Nothing is read yet.

        Args:
            root: folder of results; it may come to be later.
        """
        self.root = root
        self._read: Dict[Path, _Read] = {}

    def runs(self) -> List[Dict[str, Any]]:
        """One row a run, the newest first: ``run`` is its folder below the root; headlines; whether it has a film."""
        found: List[Tuple[float, Path]] = []
        for path in _summaries(self.root):
            try:
                found.append((path.stat().st_mtime, path))
            except OSError:
                continue
        found = sorted(found, reverse=True)[:MOST_RUNS]
        self._read = {path: self._read[path] for _, path in found if path in self._read}
        return [self._row(path, written_s) for written_s, path in found]

    def run(self, name: str) -> Dict[str, Any]:
        """All of one run's summary, and the names of the files that ``file`` gives.

        Raises:
            ResultError: there is no such run, or its summary cannot be read.
        """
        folder = self._folder(name)
        files = sorted(path.name for path in folder.iterdir() if _may_be_shown(path))
        return {
            "run": name,
            "summary": read_summary(folder / SUMMARY),
            "files": files,
            "film": (folder / FILM).is_file(),
        }

    def file(self, name: str, file: str) -> Optional[Path]:
        """A file of a run; None when there is none, or when it is of a kind that is not shown.

        Raises:
            ResultError: there is no such run.
        """
        path = self._folder(name) / file
        return path if NAME.fullmatch(file) and _may_be_shown(path) else None

    def film(self, name: str) -> Optional[Path]:
        """The film of a run; None when it has none.

        Raises:
            ResultError: there is no such run.
        """
        path = self._folder(name) / FILM
        return path if path.is_file() else None

    def _folder(self, name: str) -> Path:
        parts = name.split("/")
        well = 0 < len(parts) <= DEEPEST and all(NAME.fullmatch(part) and part.strip(".") for part in parts)
        folder = self.root.joinpath(*parts)
        if not well or not (folder / SUMMARY).is_file():
            raise ResultError(f"there is no run {name!r} below {self.root}")
        return folder

    def _row(self, path: Path, written_s: float) -> Dict[str, Any]:
        known = self._read.get(path)
        if known is None or known.written_s != written_s:
            known = self._read[path] = _Read(written_s, _headlines(path))
        name = path.parent.relative_to(self.root).as_posix()
        return {"run": name, "written_s": written_s, "film": (path.parent / FILM).is_file(), **known.row}


def _summaries(root: Path) -> List[Path]:
    patterns = ("/".join(["*"] * depth + [SUMMARY]) for depth in range(1, DEEPEST + 1))
    return [path for pattern in patterns for path in root.glob(pattern)]


def read_summary(path: Path) -> Dict[str, Any]:
    """What a summary says.

    Raises:
        ResultError: nothing that can be read.
    """
    try:
        if path.stat().st_size > LARGEST_SUMMARY:
            raise ResultError(f"{path} has more than {LARGEST_SUMMARY} bytes: it is not read")
        words = yaml.load(path.read_text(encoding="utf-8"), Loader=Loader)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ResultError(f"{path} cannot be read: {error}") from error
    if not isinstance(words, dict):
        raise ResultError(f"{path} has no names and values")
    return {str(name): _plain(value) for name, value in words.items()}


def _plain(value: Any) -> Any:
    """As JSON can say it: a number that is not finite is None, what is no plain value its text."""
    if isinstance(value, dict):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else str(value)


def _headlines(path: Path) -> Dict[str, Any]:
    try:
        words = read_summary(path)
    except ResultError as error:
        return {"success": None, "faults": [str(error)]}
    row = {name: words[name] for name in HEADLINES if isinstance(words.get(name), (str, int, float, bool))}
    faults = words.get("faults")
    row["faults"] = [str(fault) for fault in faults][:5] if isinstance(faults, list) else []
    return row


def _may_be_shown(path: Path) -> bool:
    return path.is_file() and not path.is_symlink() and (path.suffix in SHOWN or path.name == PROOF)
