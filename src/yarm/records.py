"""Dataclasses as plain values that JSON holds, and back with every value's type looked at.

Fields may be str, bool, int, float, enums, dataclasses, ``Optional``, ``Tuple[X, ...]``, tuples of fixed length and
``Dict[str, X]`` of these. Floats may be NaN and infinite.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, Dict, Tuple, Type, TypeVar, Union, get_args, get_origin, get_type_hints

T = TypeVar("T")


class RecordError(ValueError):
    """A value is not what it should be; the message says where, what it is and what was expected."""


def plain(value: Any) -> Any:
    """A value as dictionaries, lists, texts and numbers."""
    if isinstance(value, Enum):
        return value.value
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    return value


def read(kind: Type[T], value: Any, where: str = "") -> T:
    """What ``plain`` made of an instance of a dataclass, as that again.

    Raises:
        RecordError: a field is missing or one too many, or a value is of another type.
    """
    found: T = _read(kind, value, where or kind.__name__)
    return found


def _read(kind: Any, value: Any, where: str) -> Any:
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Union:
        inner = next(argument for argument in arguments if argument is not type(None))
        return None if value is None else _read(inner, value, where)
    if origin is tuple:
        return _read_tuple(arguments, value, where)
    if origin is dict:
        if not isinstance(value, dict):
            raise _wrong(where, value, "a mapping")
        return {key: _read(arguments[1], entry, f"{where}[{key!r}]") for key, entry in value.items()}
    return _read_dataclass(kind, value, where) if is_dataclass(kind) else _read_single(kind, value, where)


def _read_single(kind: Any, value: Any, where: str) -> Any:
    if issubclass(kind, Enum):
        try:
            return kind(value)
        except ValueError as error:
            raise _wrong(where, value, f"one of {[entry.value for entry in kind]}") from error
    if kind is float and isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if type(value) is not kind:
        raise _wrong(where, value, kind.__name__)
    return value


def _read_tuple(arguments: Tuple[Any, ...], value: Any, where: str) -> Tuple[Any, ...]:
    if not isinstance(value, list):
        raise _wrong(where, value, "a list")
    kinds = [arguments[0]] * len(value) if arguments[-1] is Ellipsis else list(arguments)
    if len(kinds) != len(value):
        raise _wrong(where, value, f"{len(kinds)} values")
    return tuple(_read(kind, entry, f"{where}[{i}]") for i, (kind, entry) in enumerate(zip(kinds, value)))


def _read_dataclass(kind: Any, value: Any, where: str) -> Any:
    if not isinstance(value, dict):
        raise _wrong(where, value, f"the fields of {kind.__name__}")
    hints: Dict[str, Any] = get_type_hints(kind)
    wanted = {field.name for field in fields(kind)}
    if set(value) != wanted:
        different = sorted(set(value) ^ wanted)
        raise RecordError(f"{where}: the fields of {kind.__name__} differ in {', '.join(different)}")
    return kind(**{name: _read(hints[name], value[name], f"{where}.{name}") for name in wanted})


def _wrong(where: str, value: Any, expected: str) -> RecordError:
    return RecordError(f"{where} = {str(value)[:80]!r}: expected {expected}")
