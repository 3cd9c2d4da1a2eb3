"""What an experiment must still know when its own process has died: kept on the disk, about twice a second."""

from __future__ import annotations

import os
import pickle
import threading
import time
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, Optional, Set, Tuple

from yarm.console.film import Film, FilmError
from yarm.experiments.run.record import RunRecord
from yarm.experiments.run.recorder import Recorder
from yarm.safety.supervise import LIFE

FILE, FILM = "run.saved", "film.saved"
PERIOD_S = 0.5
BUSY = 0.02
"""Greatest share of the wall time that is spent on keeping: a long run is kept less often."""
Began = Tuple[float, float, int]
"""A mission's beginning: simulated time and wall clock, s, camera sets."""


@dataclass(frozen=True, eq=False)
class SavedRun:
    """An experiment in the midst of it.

    Attributes:
        recorder: what was recorded.
        ended_s: when each goal that has ended did, simulated time, s.
        declared: goals that were reached.
        begun_again: how often the cell has begun anew.
        began: the mission's beginning; None before it.
        now_s: simulated time, s.
        record: the mission's record, once it has ended; None before.
        failure: why it could not go on; empty when nothing was in its way.
    """

    recorder: Recorder
    ended_s: Dict[str, float]
    declared: Set[str]
    begun_again: int
    began: Optional[Began]
    now_s: float
    record: Optional[RunRecord]
    failure: str


class Saver:
    """Keeps a run in a file of its folder, under a supervisor only: nobody else would take it up."""

    def __init__(self, folder: Path) -> None:
        """Nothing is written yet."""
        self._path, self._film_path = folder / FILE, folder / FILM
        self._film, self._blocks = Film(), 0
        self._life = os.environ.get(LIFE, "").encode()
        self._writing, self._ended = threading.Lock(), threading.Event()
        self._take: Optional[Callable[[], bytes]] = None
        self._thread: Optional[threading.Thread] = None

    def found(self) -> Optional[SavedRun]:
        """What the process before, of the same supervisor, has left; None for nothing."""
        if not self._life or not self._path.is_file():
            return None
        life, _, run = self._path.read_bytes().partition(b"\n")
        if life != self._life:
            return None
        saved: SavedRun = pickle.loads(run)
        return saved

    def film(self) -> Optional[Film]:
        """The film of the process before, but for its last seconds; None when there is none."""
        with suppress(FilmError):
            return Film.read(self._film_path) if self._film_path.is_file() else None
        return None

    def begin(
        self, run: Callable[[], SavedRun], lock: AbstractContextManager[object], film: Optional[Film] = None
    ) -> None:
        """Keep what ``run`` gives, which is called with the lock held, about twice a second until ``end``.

        Args:
            run: gives what is kept.
            lock: that it is called with.
            film: is kept, too, with each block of it that is whole.
        """

        def take() -> bytes:
            with lock:
                return pickle.dumps(run(), protocol=pickle.HIGHEST_PROTOCOL)

        if self._life:
            if self.found() is None:
                self._film_path.unlink(missing_ok=True)
            self._take, self._film = take, film or self._film
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._thread = threading.Thread(target=self._run, daemon=True)
            self._thread.start()

    def keep(self) -> None:
        """Keep it now; a file is there whole or not at all."""
        if self._take is None:
            return
        with self._writing:
            new = self._path.with_suffix(".new")
            new.write_bytes(self._life + b"\n" + self._take())
            new.replace(self._path)
            blocks = self._film.blocks
            if blocks != self._blocks:
                self._blocks = blocks
                new = self._film_path.with_suffix(".new")
                self._film.write(new)
                new.replace(self._film_path)

    def end(self) -> None:
        """Nothing needs to be taken up any more."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
            self._path.unlink(missing_ok=True)
            self._film_path.unlink(missing_ok=True)

    def _run(self) -> None:
        pause_s = PERIOD_S
        while not self._ended.wait(pause_s):
            began_s = time.monotonic()
            self.keep()
            pause_s = max(PERIOD_S, (time.monotonic() - began_s) / BUSY)
