"""Reading typed fields out of a YAML mapping, gathering every fault instead of stopping at the first."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Set, Tuple

import yaml


class SceneError(ValueError):
    """A scene file cannot be used; the message lists every fault: file, key, value and what was expected."""


class Faults:
    """The faults found in one file."""

    def __init__(self, file: str) -> None:
        """Gather faults of the named file."""
        self.file = file
        self.lines: List[str] = []

    def add(self, key: str, value: object, expected: str) -> None:
        """Note that a key's value is not what was expected."""
        self.lines.append(f"{self.file}: {key} = {value!r}: expected {expected}")

    def raise_if_any(self) -> None:
        """End the reading.

        Raises:
            SceneError: there were faults; all are listed.
        """
        if self.lines:
            raise SceneError("\n".join(self.lines))


class Fields:
    """One mapping of the file; each read marks its key as known, ``finish`` reports the rest as unknown."""

    def __init__(self, raw: object, key: str, faults: Faults) -> None:
        """Wrap a raw YAML value that must be a mapping; ``key`` is its path in the file."""
        self.key = key
        self.faults = faults
        self._known: Set[str] = set()
        self.raw: Mapping[str, Any] = raw if isinstance(raw, dict) else {}
        if not isinstance(raw, dict):
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
            if required:
                self.faults.add(self.path(name), None, f"{expected} (the key is missing)")
            return default
        return self.raw[name]

    def number(self, name: str, low: float, high: float, unit: str, default: Optional[float] = None) -> float:
        """A finite number within [low, high]; required when there is no default."""
        expected = f"a number within {low:g} to {high:g}{' ' + unit if unit else ''}"
        value = self.value(name, expected, default, required=default is None)
        if value is None:
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

    def entries(self, name: str) -> List[Fields]:
        """A list of mappings; an absent key is an empty list."""
        value = self.value(name, "a list", [])
        if not isinstance(value, list):
            self.faults.add(self.path(name), value, "a list")
            return []
        return [Fields(item, f"{self.path(name)}[{i}]", self.faults) for i, item in enumerate(value)]

    def section(self, name: str) -> Fields:
        """A required mapping."""
        return Fields(self.value(name, "a mapping", {}, required=True), self.path(name), self.faults)

    def finish(self) -> None:
        """Report every key that nobody read."""
        for name in self.raw:
            if name not in self._known:
                self.faults.add(
                    self.path(str(name)), self.raw[name], f"no such key; known: {', '.join(sorted(self._known))}"
                )


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


class _UniqueKeyLoader(yaml.SafeLoader):  # type: ignore[misc]
    """YAML that refuses a key given twice, which YAML itself lets the last one win."""

    def construct_mapping(self, node: Any, deep: bool = False) -> Dict[Any, Any]:
        seen: Set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise yaml.YAMLError(f"line {key_node.start_mark.line + 1}: key {key!r} given twice")
            seen.add(key)
        mapping: Dict[Any, Any] = super().construct_mapping(node, deep)
        return mapping


def load_yaml(path: Path) -> object:
    """The content of a YAML file.

    Raises:
        SceneError: no such file, not YAML, or a key given twice.
    """
    if not path.is_file():
        raise SceneError(f"{path}: no such file")
    try:
        return yaml.load(path.read_text(encoding="utf-8"), Loader=_UniqueKeyLoader)
    except yaml.YAMLError as error:
        raise SceneError(f"{path}: not readable as YAML: {error}") from error
