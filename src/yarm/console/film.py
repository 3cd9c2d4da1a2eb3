"""Pictures over time: the last minutes of a running system, or a recorded run; one form for both.

A film is a row of blocks of a few seconds, each of which can be shown without the ones before: it begins with
whatever seldom changes (``Part``). A block is compressed by zlib, little-endian:

    pieces, uint32 | each piece: length, uint32, and bytes | entries, uint32 |
    each entry: time, float64, s | pieces it is made of, uint32 | their numbers, uint32 each

An entry is one message of ``yarm.console.wire``; what is the same in several of them is one piece.
"""

from __future__ import annotations

import base64
import json
import struct
import threading
import zlib
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Deque, Dict, Iterator, List, Mapping, Optional, Tuple

from yarm.console.cell import Part
from yarm.console.wire import decode, pieces_of

MAGIC = b"YRF1"
BLOCK_S = 5.0
"""Simulated time of a block, s."""
MOST_EVENTS = 2000
"""Events of a whole film that its index keeps; the oldest go."""
MOST_NOTES = 20
EVENTS = "events"
COUNT, HEAD = struct.Struct("<I"), struct.Struct("<dI")
LEVEL = 6


class FilmError(ValueError):
    """A file is no film; the message says which file and why."""


@dataclass(frozen=True)
class Block:
    """A few seconds: simulated time of the first and the last picture, s, number of pictures, and all of them."""

    first_s: float
    last_s: float
    pictures: int
    data: bytes


@dataclass
class _Open:
    """The block that is being filled: for each entry its time and its pieces, of which some are of others, too."""

    entries: List[Tuple[float, List[bytes]]] = field(default_factory=list)
    versions: Dict[str, int] = field(default_factory=dict)
    times: List[float] = field(default_factory=list)

    def closed(self) -> Block:
        return Block(self.times[0], self.times[-1], len(self.times), pack(self.entries))


class Film:
    """Takes in pictures in the order of their times and gives them back in blocks. Thread-safe."""

    def __init__(self, title: str = "", keep_s: float = float("inf")) -> None:
        """Empty.

        Args:
            title: what it shows, for people; ``notes`` is what they should know of it.
            keep_s: so much of it is kept, s of its own time; whole blocks that are older go.
        """
        self.title = title
        self.notes: List[str] = []
        self._keep_s = keep_s
        self._lock = threading.Lock()
        self._begin()
        self._first = 0

    def _begin(self) -> None:
        self._blocks: Deque[Block] = deque()
        self._open = _Open()
        self._events: Dict[Tuple[float, str, str], Dict[str, Any]] = {}
        self._heard = -1

    def add(self, time_s: float, parts: Mapping[str, Part], state: bytes) -> None:
        """One more picture; one that is older than the last means that time began anew, and so does the film.

        Args:
            time_s: simulated time, s.
            parts: what seldom changes, by name.
            state: all the rest, a message of ``yarm.console.wire``.
        """
        with self._lock:
            last_s = self._last_s()
            if last_s is not None and time_s < last_s:
                self._first += len(self._blocks) + 1
                self._begin()
            if self._open.times and time_s - self._open.times[0] >= BLOCK_S:
                self._close()
            block = self._open
            for name, part in parts.items():
                if block.versions.get(name) != part.version:
                    block.versions[name] = part.version
                    block.entries.append((time_s, pieces_of(part.message)))
            if EVENTS in parts and parts[EVENTS].version != self._heard:
                self._heard = parts[EVENTS].version
                self._take_events(decode(parts[EVENTS].message)[0]["events"])
            block.entries.append((time_s, pieces_of(state)))
            block.times.append(time_s)

    def begin_with(self, before: Film) -> None:
        """All that another film has comes first."""
        with self._lock:
            self._blocks.extend(before._blocks)
            self._events.update(before._events)
            self.notes.extend(before.notes)

    def note(self, text: str) -> None:
        """What a person who looks at it should know, once."""
        if text not in self.notes and len(self.notes) < MOST_NOTES:
            self.notes.append(text)

    def index(self) -> Dict[str, Any]:
        """What there is: ``first`` is the number of the first block, ``blocks`` and ``events`` are in their order."""
        with self._lock:
            blocks = [(b.first_s, b.last_s, b.pictures) for b in self._blocks]
            if self._open.times:
                blocks.append((self._open.times[0], self._open.times[-1], len(self._open.times)))
            return {
                "title": self.title,
                "notes": list(self.notes),
                "first": self._first,
                "blocks": [{"first_s": a, "last_s": b, "pictures": n} for a, b, n in blocks],
                "events": list(self._events.values()),
            }

    def block(self, number: int) -> Optional[bytes]:
        """The bytes of a block, by its number; None for one that is gone or not there yet."""
        with self._lock:
            at = number - self._first
            if 0 <= at < len(self._blocks):
                return self._blocks[at].data
            return self._open.closed().data if at == len(self._blocks) and self._open.times else None

    @property
    def blocks(self) -> int:
        """How many blocks have been closed, those that are gone included."""
        with self._lock:
            return self._first + len(self._blocks)

    def bytes_kept(self) -> int:
        """Bytes of all closed blocks."""
        with self._lock:
            return sum(len(block.data) for block in self._blocks)

    def write(self, path: Path) -> None:
        """All of it into a file.

        Raises:
            OSError: it cannot be written.
        """
        index = self.index()
        blocks = [self.block(index["first"] + i) or b"" for i in range(len(index["blocks"]))]
        index["first"], index["bytes"] = 0, [len(block) for block in blocks]
        words = json.dumps(index, allow_nan=False, separators=(",", ":")).encode()
        path.write_bytes(b"".join([MAGIC, COUNT.pack(len(words)), words, *blocks]))

    @staticmethod
    def read(path: Path) -> Film:
        """A film from a file.

        Raises:
            FilmError: it cannot be read, or is none.
        """
        try:
            data = path.read_bytes()
            if data[:4] != MAGIC:
                raise ValueError(f"it begins with {data[:4]!r}, expected {MAGIC!r}")
            (length,) = COUNT.unpack_from(data, 4)
            index, at = json.loads(data[8 : 8 + length]), 8 + length
            film = Film(str(index["title"]))
            for entry, size in zip(index["blocks"], index["bytes"]):
                if at + size > len(data):
                    raise ValueError(
                        f"it ends after {len(data)} bytes, block {len(film._blocks)} goes on to {at + size}"
                    )
                film.take(entry, data[at : at + size])
                at += size
            film.notes = [str(note) for note in index["notes"]]
            film._take_events(index["events"])
        except (OSError, ValueError, KeyError, TypeError, struct.error) as error:
            raise FilmError(f"{path} is no film that can be shown: {error}") from error
        return film

    def take(self, entry: Mapping[str, Any], data: bytes) -> None:
        """A whole block behind the last one: its entry in an index, and its bytes."""
        self._blocks.append(Block(entry["first_s"], entry["last_s"], entry["pictures"], data))

    def as_text(self) -> Dict[str, Any]:
        """Index and blocks, as JSON can say them: ``data`` has each block in base64."""
        index = self.index()
        blocks = [self.block(index["first"] + i) or b"" for i in range(len(index["blocks"]))]
        return {**index, "first": 0, "data": [base64.b64encode(block).decode() for block in blocks]}

    def _last_s(self) -> Optional[float]:
        if self._open.times:
            return self._open.times[-1]
        return self._blocks[-1].last_s if self._blocks else None

    def _close(self) -> None:
        self._blocks.append(self._open.closed())
        self._open = _Open()
        while self._blocks[-1].last_s - self._blocks[0].last_s > self._keep_s:
            self._blocks.popleft()
            self._first += 1

    def _take_events(self, events: List[Dict[str, Any]]) -> None:
        for event in events:
            self._events[event["time_s"], event["node"], event["text"]] = event
        while len(self._events) > MOST_EVENTS:
            del self._events[next(iter(self._events))]


def pack(entries: List[Tuple[float, List[bytes]]]) -> bytes:
    """A block of entries, each a time and the pieces of a message. Pieces of the same place stand side by side."""
    places = max((len(pieces) for _, pieces in entries), default=0)
    known: Dict[bytes, int] = {}
    for place in range(places):
        for _, pieces in entries:
            if place < len(pieces):
                known.setdefault(pieces[place], len(known))
    words = [COUNT.pack(len(known))]
    words += [part for piece in known for part in (COUNT.pack(len(piece)), piece)]
    words.append(COUNT.pack(len(entries)))
    for time_s, pieces in entries:
        words.append(HEAD.pack(time_s, len(pieces)))
        words += [COUNT.pack(known[piece]) for piece in pieces]
    return zlib.compress(b"".join(words), LEVEL)


def unpack(data: bytes) -> Iterator[Tuple[float, bytes]]:
    """Time, s, and message of each entry of a block."""
    plain = zlib.decompress(data)
    (count,), at = COUNT.unpack_from(plain), COUNT.size
    pieces = []
    for _ in range(count):
        (length,) = COUNT.unpack_from(plain, at)
        pieces.append(plain[at + COUNT.size : at + COUNT.size + length])
        at += COUNT.size + length
    (count,), at = COUNT.unpack_from(plain, at), at + COUNT.size
    for _ in range(count):
        time_s, number = HEAD.unpack_from(plain, at)
        at += HEAD.size
        numbers = struct.unpack_from(f"<{number}I", plain, at)
        at += COUNT.size * number
        yield time_s, b"".join(pieces[i] for i in numbers)
