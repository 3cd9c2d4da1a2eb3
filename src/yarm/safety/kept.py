"""What a program keeps over its own death: a few words with its supervisor (``yarm.safety.supervise``), in memory.

Only the supervisor and its program have the file; it is on no disk, and gone with the supervisor.
"""

from __future__ import annotations

import json
import os
from typing import Dict, Optional

KEPT = "YARM_KEPT"
"""Variable with the number of the file that the words are in."""


def made() -> int:
    """A file for the words of one program; the supervisor hands it on to each of its processes."""
    return os.memfd_create("kept")


class Kept:
    """The words of the process before, and those for the next one; without a supervisor there are none."""

    def __init__(self) -> None:
        """Find the file; programs that this one starts do not inherit it."""
        self._file: Optional[int] = None
        number = os.environ.get(KEPT, "")
        if number.isdigit():
            try:
                os.set_inheritable(int(number), False)
                self._file = int(number)
            except OSError:
                return

    def words(self) -> Dict[str, str]:
        """What the process before has kept; empty for the first one."""
        if self._file is None:
            return {}
        try:
            found = json.loads(os.pread(self._file, os.fstat(self._file).st_size, 0))
        except (OSError, ValueError):
            return {}
        return {str(key): str(value) for key, value in found.items()} if isinstance(found, dict) else {}

    def keep(self, words: Dict[str, str]) -> None:
        """Keep these in place of those before."""
        if self._file is not None:
            data = json.dumps(words).encode()
            os.pwrite(self._file, data, 0)
            os.ftruncate(self._file, len(data))
