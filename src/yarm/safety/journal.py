"""A journal: what a process must still know after its death, appended line by line (docs/safety.md, "Nodes that die").

    journal, found = Journal.open(path, "commander", life)
    found.records            # of the process before, in order; none when there is nothing to take up, and why
    journal.begin([record])  # everything before is of no use any more
    journal.append(record)   # survives the process; with sync=True the machine's power, too

Each line holds a checksum and a record in JSON. The first names what it is of and the life it belongs to: that of the
process's supervisor, so that a journal of yesterday, or of another system, is never taken up.
"""

from __future__ import annotations

import json
import os
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

Record = Dict[str, Any]
LAYOUT = 1
"""Number of this layout; a journal of another one is not read."""
MOST_BYTES = 4_000_000
"""A longer file is no journal of ours, bytes."""


@dataclass(frozen=True)
class Found:
    """What a journal held when it was opened.

    Attributes:
        records: in order, without the first line.
        complaint: what is wrong with it, for people; empty when nothing is. Records that it left are good.
    """

    records: Tuple[Record, ...] = ()
    complaint: str = ""


class Journal:
    """One file, written by one process. Not thread-safe."""

    def __init__(self, path: Path, header: Record) -> None:
        """Use ``open``."""
        self._path = path
        self._header = header
        self._file: Optional[int] = None
        self.size = 0

    @staticmethod
    def open(path: Path, of: str, life: str) -> Tuple[Journal, Found]:
        """The journal in a file, and what it holds; nothing is written before ``begin``.

        Args:
            path: of the file, which need not be there.
            of: what it is a journal of.
            life: what it must have been begun in to be taken up.
        """
        header = {"journal": of, "layout": LAYOUT, "life": life}
        return Journal(path, header), _read(path, header)

    def begin(self, records: Sequence[Record]) -> None:
        """Start over with these records, in one stroke: the file is the old one or the new one, never half of it.

        Raises:
            OSError: the file cannot be written.
        """
        self.close()
        self._path.parent.mkdir(parents=True, exist_ok=True)
        fresh = self._path.with_name(self._path.name + ".new")
        text = b"".join(_line(record) for record in [self._header, *records])
        file = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o600)
        try:
            _write(file, text)
            os.fsync(file)
            os.replace(fresh, self._path)
        except OSError:
            os.close(file)
            raise
        self._file, self.size = file, len(text)

    def append(self, record: Record, sync: bool = False) -> None:
        """Add a record; with ``sync`` it is on the disk when this returns.

        Raises:
            OSError: it cannot be written.
            ValueError: nothing was begun.
        """
        if self._file is None:
            raise ValueError(f"{self._path}: begin the journal first")
        text = _line(record)
        _write(self._file, text)
        self.size += len(text)
        if sync:
            os.fsync(self._file)

    def close(self) -> None:
        """Write no more."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def discard(self) -> None:
        """Nothing in it shall be taken up.

        Raises:
            OSError: the file cannot be removed.
        """
        self.close()
        self._path.unlink(missing_ok=True)


def _write(file: int, text: bytes) -> None:
    while text:
        text = text[os.write(file, text) :]


def _line(record: Record) -> bytes:
    text = json.dumps(record, separators=(",", ":")).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _record(line: bytes) -> Optional[Record]:
    """What a line holds; None when it is damaged."""
    checksum, _, text = line.partition(b" ")
    try:
        record = json.loads(text) if checksum == b"%08x" % zlib.crc32(text) else None
    except (ValueError, RecursionError):
        return None
    return record if isinstance(record, dict) else None


def _read(path: Path, header: Record) -> Found:
    try:
        with path.open("rb") as file:
            text = file.read(MOST_BYTES + 1)
    except FileNotFoundError:
        return Found()
    except OSError as error:
        return Found(complaint=f"{path} cannot be read: {error.strerror}")
    *lines, torn = text.split(b"\n")
    records = [_record(line) for line in lines]
    wrong = _fault(records, header) if len(text) <= MOST_BYTES else f"has more than {MOST_BYTES} bytes"
    if wrong:
        return Found(complaint=f"{path} {wrong}")
    good = tuple(record for record in records[1:] if record is not None)
    return Found(good, f"{path}: its last line is cut off and left out" if torn else "")


def _fault(records: Sequence[Optional[Record]], header: Record) -> str:
    """Why the lines of a file are not to be taken up; empty when they are."""
    first = records[0] if records else None
    if first is None:
        return "does not begin as a journal does"
    if first != header:
        different = ", ".join(f"{key} {first.get(key)!r}, not {header[key]!r}" for key in _unlike(first, header))
        return f"is another one's: {different}"
    return f"is damaged in line {records.index(None) + 1} of {len(records)}" if None in records else ""


def _unlike(a: Record, b: Record) -> List[str]:
    return [key for key in b if a.get(key) != b[key]] or ["unknown fields in its first line"]
