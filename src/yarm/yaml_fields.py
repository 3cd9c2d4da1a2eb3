"""Reading typed fields out of a YAML mapping, gathering every fault instead of stopping at the first.

A file is refused before it can cost much: by its size, by how deep and how often its values repeat each other
(aliases are counted as if they were written out), and by the length of every list.
"""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Set, Tuple

import yaml

MOST_BYTES = 1_000_000
"""Largest file that is read, bytes."""
MOST_VALUES = 60_000
"""Most values a file may hold, every alias written out: lists, mappings, keys and what is in them."""
DEEPEST = 20
"""Lists and mappings inside each other, at most."""
MOST_DIGITS = 60
"""Longest number, characters."""
MOST_TEXT = 2000
"""Longest text, characters."""
MOST_ENTRIES = 500
"""Longest list of mappings, unless a reader says otherwise."""
MOST_FAULTS = 50
"""Faults listed one by one; the rest are counted."""
MOST_SHOWN = 80
"""Characters of a wrong value that are shown."""


class SceneError(ValueError):
    """A scene file cannot be used; the message lists every fault: file, key, value and what was expected."""


class Faults:
    """The faults found in one file."""

    def __init__(self, file: str) -> None:
        """Gather faults of the named file."""
        self.file = file
        self.lines: List[str] = []
        self._count = 0

    def add(self, key: str, value: object, expected: str) -> None:
        """Note that a key's value is not what was expected."""
        shown = repr(value)
        shown = shown if len(shown) <= MOST_SHOWN else f"{shown[:MOST_SHOWN]}..."
        self._add(f"{self.file}: {key or 'top level'} = {shown}: expected {expected}")

    def add_missing(self, key: str, expected: str) -> None:
        """Note that a key is not there."""
        self._add(f"{self.file}: {key} is missing: expected {expected}")

    def _add(self, line: str) -> None:
        self._count += 1
        if self._count <= MOST_FAULTS:
            self.lines.append(line)

    def raise_if_any(self) -> None:
        """End the reading.

        Raises:
            SceneError: there were faults; all are listed.
        """
        if self._count > MOST_FAULTS:
            raise SceneError("\n".join([*self.lines, f"{self.file}: and {self._count - MOST_FAULTS} faults more"]))
        if self.lines:
            raise SceneError("\n".join(self.lines))


class Fields:
    """One mapping of the file; each read marks its key as known, ``finish`` reports the rest as unknown."""

    def __init__(self, raw: object, key: str, faults: Faults, absent: bool = False) -> None:
        """Wrap a raw YAML value that must be a mapping.

        Args:
            raw: the value.
            key: its path in the file.
            faults: where faults go.
            absent: it is known to be missing, so that nothing more needs to be said of it or of what should be in it.
        """
        self.key = key
        self.faults = faults
        self._known: Set[str] = set()
        self.raw: Mapping[str, Any] = raw if isinstance(raw, dict) else {}
        self._usable = isinstance(raw, dict)
        if not self._usable and not absent:
            faults.add(key, raw, "a mapping of keys to values")

    def path(self, name: str) -> str:
        """Path of a key in the file, for messages."""
        return f"{self.key}.{name}" if self.key else name

    def has(self, name: str) -> bool:
        """Whether the key is given."""
        return name in self.raw

    def value(self, name: str, expected: str, default: Any = None, required: bool = False) -> Any:
        """The raw value of a key."""
        self._known.add(name)
        if name not in self.raw:
            if required and self._usable:
                self.faults.add_missing(self.path(name), expected)
            return default
        return self.raw[name]

    def number(self, name: str, low: float, high: float, unit: str, default: Optional[float] = None) -> float:
        """A finite number within [low, high]; required when there is no default."""
        expected = f"a number within {low:g} to {high:g}{' ' + unit if unit else ''}"
        value = self.value(name, expected, default, required=default is None)
        if value is None and not self.has(name):
            return low
        if not _is_number(value) or not low <= value <= high:
            self.faults.add(self.path(name), value, expected)
            return low
        return float(value)

    def whole(self, name: str, low: int, high: int, default: int) -> int:
        """A whole number within [low, high]."""
        expected = f"a whole number within {low} to {high}"
        value = self.value(name, expected, default)
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            self.faults.add(self.path(name), value, expected)
            return default
        return value

    def flag(self, name: str, default: Optional[bool] = None) -> bool:
        """True or false; required when there is no default."""
        value = self.value(name, "true or false", default, required=default is None)
        if not isinstance(value, bool) and (value is not None or self.has(name)):
            self.faults.add(self.path(name), value, "true or false")
        return bool(value)

    def text(self, name: str, default: Optional[str] = None, choices: Sequence[str] = ()) -> str:
        """A text, one of the choices when there are any; required when there is no default."""
        expected = f"one of {', '.join(choices)}" if choices else "a text"
        value = self.value(name, expected, default, required=default is None)
        if value is None and not self.has(name):
            return ""
        if not isinstance(value, str) or not value or (choices and value not in choices):
            self.faults.add(self.path(name), value, expected)
            return ""
        if len(value) > MOST_TEXT:
            self.faults.add(self.path(name), value, f"at most {MOST_TEXT} characters, not {len(value)}")
            return ""
        return value

    def numbers(self, name: str, n: int, low: float, high: float, default: Any = None) -> Tuple[float, ...]:
        """A list of n finite numbers within [low, high]; required when there is no default."""
        expected = f"a list of {n} numbers within {low:g} to {high:g}"
        value = self.value(name, expected, default, required=default is None)
        if value is None and not self.has(name):
            return (low,) * n
        good = isinstance(value, (list, tuple)) and len(value) == n
        if not good or not all(_is_number(item) and low <= item <= high for item in value):
            self.faults.add(self.path(name), value, expected)
            return (low,) * n
        return tuple(float(item) for item in value)

    def wholes(self, name: str, n: int, low: int, high: int) -> Optional[Tuple[int, ...]]:
        """A required list of n whole numbers within [low, high]; None when it is wrong."""
        expected = _wholes_expected(n, low, high)
        value = self.value(name, expected, required=True)
        if not self.has(name):
            return None
        numbers = _wholes(value, n, low, high)
        if numbers is None:
            self.faults.add(self.path(name), value, expected)
        return numbers

    def rows(self, name: str, n: int, low: int, high: int, most: int) -> List[Tuple[str, Tuple[int, ...]]]:
        """A list of at most ``most`` lists of n whole numbers within [low, high]; an absent key is an empty list.

        Returns:
            path in the file and numbers of each row that is right.
        """
        found = []
        for i, value in enumerate(self._items(name, most)):
            numbers = _wholes(value, n, low, high)
            if numbers is None:
                self.faults.add(f"{self.path(name)}[{i}]", value, _wholes_expected(n, low, high))
            else:
                found.append((f"{self.path(name)}[{i}]", numbers))
        return found

    def entries(self, name: str, most: int = MOST_ENTRIES) -> List[Fields]:
        """A list of at most ``most`` mappings; an absent key is an empty list."""
        return [Fields(item, f"{self.path(name)}[{i}]", self.faults) for i, item in enumerate(self._items(name, most))]

    def _items(self, name: str, most: int) -> List[Any]:
        value = self.value(name, "a list", [])
        if not isinstance(value, list):
            self.faults.add(self.path(name), value, "a list")
            return []
        if len(value) > most:
            self.faults.add(self.path(name), f"{len(value)} entries", f"at most {most}")
            return []
        return value

    def section(self, name: str) -> Fields:
        """A required mapping."""
        value = self.value(name, "a mapping of keys to values", required=True)
        return Fields(value, self.path(name), self.faults, absent=not self.has(name))

    def finish(self, *optional: str) -> None:
        """Report every key that nobody read, but the optional ones named."""
        self._known.update(optional)
        for name in self.raw:
            if name not in self._known:
                self.faults.add(
                    self.path(str(name)), self.raw[name], f"no such key; known: {', '.join(sorted(self._known))}"
                )


def _is_number(value: object) -> bool:
    if isinstance(value, bool):
        return False
    return isinstance(value, int) or (isinstance(value, float) and math.isfinite(value))


def _wholes_expected(n: int, low: int, high: int) -> str:
    return f"a list of {n} whole numbers within {low} to {high}"


def _wholes(value: object, n: int, low: int, high: int) -> Optional[Tuple[int, ...]]:
    if not isinstance(value, list) or len(value) != n:
        return None
    good = all(_is_number(item) and low <= item <= high and int(item) == item for item in value)
    return tuple(int(item) for item in value) if good else None


class _BoundedLoader(yaml.SafeLoader):  # type: ignore[misc]
    """YAML that refuses what costs too much to read, and a key given twice, which YAML lets the last one win."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._values = 0
        self._depth = 0
        self._sizes: Dict[Any, int] = {}

    def compose_node(self, parent: Any, index: Any) -> Any:
        event = self.peek_event()
        where = f"line {event.start_mark.line + 1}"
        if getattr(event, "tag", None) is not None:
            raise yaml.YAMLError(f"{where}: the tag {event.tag} is not accepted; write plain values")
        before, self._depth = self._values, self._depth + 1
        if self._depth > DEEPEST:
            raise yaml.YAMLError(f"{where}: lists and mappings nested deeper than {DEEPEST}")
        node = super().compose_node(parent, index)
        self._depth -= 1
        if isinstance(event, yaml.AliasEvent):
            if node not in self._sizes:
                raise yaml.YAMLError(f"{where}: *{event.anchor} stands inside what it repeats")
            self._values += self._sizes[node]
        else:
            self._values += 1
            self._sizes[node] = self._values - before
        if self._values > MOST_VALUES:
            raise yaml.YAMLError(f"{where}: more than {MOST_VALUES} values, counting what is repeated by aliases")
        if isinstance(node, yaml.ScalarNode) and node.tag in _NUMBER_TAGS and len(node.value) > MOST_DIGITS:
            raise yaml.YAMLError(f"{where}: a number of {len(node.value)} characters; at most {MOST_DIGITS}")
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> Dict[Any, Any]:
        seen: Set[Any] = set()
        for key_node, _ in node.value:
            if not isinstance(key_node, yaml.ScalarNode):
                raise yaml.YAMLError(
                    f"line {key_node.start_mark.line + 1}: a key must be a word, not a list or mapping"
                )
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise yaml.YAMLError(f"line {key_node.start_mark.line + 1}: key {key!r} given twice")
            seen.add(key)
        mapping: Dict[Any, Any] = super().construct_mapping(node, deep)
        return mapping


_NUMBER_TAGS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")


def load_yaml(path: Path) -> object:
    """The content of a YAML file.

    Raises:
        SceneError: no such file, too large, not YAML, or a key given twice.
    """
    if not os.path.isfile(path):  # Path.is_file() raises where a name is too long to be one
        raise SceneError(f"{path}: no such file")
    try:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise SceneError(f"{path}: cannot be read: {error}") from error
    if len(content) > MOST_BYTES:
        raise SceneError(f"{path}: is {path.stat().st_size} bytes; a scene has at most {MOST_BYTES}")
    try:
        return parse_yaml(content.decode("utf-8"))
    except (SceneError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: not readable as YAML: {error}") from error


def parse_yaml(text: str) -> object:
    """The content of a YAML text.

    Raises:
        SceneError: not YAML, too many or too deeply nested values, a number too long, a tag, or a key given twice.
    """
    loader = None
    try:
        loader = _BoundedLoader(text)
        return loader.get_single_data()
    except (yaml.YAMLError, ValueError) as error:
        raise SceneError(" ".join(str(error).split())) from error
    finally:
        if loader is not None:
            loader.dispose()
