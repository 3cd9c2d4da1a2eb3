"""Raw results of a benchmark: a CSV file that grows row by row, so that a stopped run goes on where it was."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

Row = Dict[str, str]


class Table:
    """Rows of a CSV file, each known by the columns of its key."""

    def __init__(self, path: Path, keys: Sequence[str], values: Sequence[str]) -> None:
        """Open a file, or begin one.

        Args:
            path: of the file.
            keys: columns that tell one row from another.
            values: the other columns.

        Raises:
            ValueError: the file has other columns.
        """
        self._path, self._keys, self._columns = path, tuple(keys), [*keys, *values]
        self._known: Dict[Tuple[str, ...], Row] = {}
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            with path.open("w", newline="", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerow(self._columns)
        rows = read_rows(path)
        if rows and list(rows[0]) != self._columns:
            raise ValueError(f"{path} has the columns {', '.join(rows[0])}, not {', '.join(self._columns)}: remove it")
        for row in rows:
            self._known[self._key(row)] = row

    def add(self, key: Mapping[str, Any], make: Callable[[], Mapping[str, Any]]) -> Optional[Row]:
        """Make and keep a row unless there is one of this key; gives the row when it is new."""
        if self._key(key) in self._known:
            return None
        given = {**key, **make()}
        row = {name: str(given[name]) for name in self._columns}
        self._known[self._key(row)] = row
        with self._path.open("a", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, self._columns, lineterminator="\n").writerow(row)
        return row

    def _key(self, row: Mapping[str, Any]) -> Tuple[str, ...]:
        return tuple(str(row[name]) for name in self._keys)


def read_rows(path: Path) -> List[Row]:
    """Every row of a CSV file as text by column; none when there is no such file."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
