"""Parameters as frozen dataclasses: default, unit, range and meaning stand once, beside each field.

    @dataclass(frozen=True)
    class ServerParams:
        cap_mps: float = param(1.0, "m/s", "largest speed of the fastest point of a robot", low=0.05, high=5.0)

    params = build(ServerParams, {"cap_mps": 0.5})

Unknown names and values out of range are refused all at once, by name, value and what is allowed.
"""

from __future__ import annotations

import dataclasses
import math
import re
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Type, TypeVar

T = TypeVar("T")
PrimitiveTypes = (bool, int, float, str)
FORMS: Dict[str, str] = {"module:Class": r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*"}
"""Forms that a string may have, each with the regular expression of the whole string."""


class ParamError(ValueError):
    """One or more parameters are wrong; the message lists every one."""


@dataclasses.dataclass(frozen=True)
class ParamInfo:
    """What is allowed for one parameter. ``low`` and ``high`` are inclusive; for a list they hold for each item.

    A string is one of the choices, or has the form (a key of ``FORMS``) if one is given.
    """

    unit: str
    doc: str
    low: Optional[float] = None
    high: Optional[float] = None
    choices: Optional[Tuple[str, ...]] = None
    form: str = ""

    @property
    def allowed(self) -> str:
        """The allowed values, for messages and docs."""
        if self.choices is not None:
            return "one of " + ", ".join(repr(c) for c in self.choices) + (f", or {self.form}" if self.form else "")
        if self.low is None and self.high is None:
            return "any"
        low = "-inf" if self.low is None else f"{self.low:g}"
        high = "inf" if self.high is None else f"{self.high:g}"
        return f"{low} to {high}"


def param(
    default: Any,
    unit: str,
    doc: str,
    low: Optional[float] = None,
    high: Optional[float] = None,
    choices: Optional[Sequence[str]] = None,
    form: str = "",
) -> Any:
    """A dataclass field that is a parameter; a list default is kept as a tuple.

    Args:
        default: bool, int, float, str or a tuple of one of them.
        unit: unit, or "" where there is none.
        doc: meaning, one sentence.
        low: least allowed value, inclusive.
        high: greatest allowed value, inclusive.
        choices: allowed strings.
        form: besides the choices, any string of this form (a key of ``FORMS``).
    """
    info = ParamInfo(unit, doc, low, high, None if choices is None else tuple(choices), form)
    return dataclasses.field(default=default, metadata={"param": info})


def infos(cls: Type[Any]) -> List[Tuple[str, Any, ParamInfo]]:
    """Name, default and info of each parameter of a parameter class, in order of declaration."""
    return [(f.name, f.default, f.metadata["param"]) for f in dataclasses.fields(cls) if "param" in f.metadata]


def build(cls: Type[T], values: Mapping[str, Any], where: str = "") -> T:
    """An instance from plain values (a YAML mapping, a parameter server's answer).

    Raises:
        ParamError: unknown names, wrong types, values out of range; all are listed.
    """
    clean, faults = _clean(cls, values)
    if faults:
        raise ParamError(f"{where or cls.__name__}: " + "; ".join(faults))
    return cls(**clean)


def build_noting(cls: Type[T], values: Mapping[str, Any], prefix: str, faults: List[str]) -> Optional[T]:
    """As :func:`build`, for one who has more to check: None with every fault noted, each parameter's name prefixed."""
    clean, found = _clean(cls, values)
    faults += [prefix + fault for fault in found]
    return None if found else cls(**clean)


def _clean(cls: Type[Any], values: Mapping[str, Any]) -> Tuple[Dict[str, Any], List[str]]:
    """The values that are given, in their types, and what is wrong with them."""
    known = {name: (default, info) for name, default, info in infos(cls)}
    faults = [f"{name}: unknown parameter; known: {', '.join(known)}" for name in values if name not in known]
    clean = {}
    for name, (default, info) in known.items():
        if name in values:
            value, fault = _checked(values[name], default, info)
            if fault:
                faults.append(f"{name} = {values[name]!r}: {fault}")
            clean[name] = value
    return clean, faults


def has_form(value: str, form: str) -> bool:
    """Whether a string has a form, a key of ``FORMS``; the empty form is nobody's."""
    return bool(form) and re.fullmatch(FORMS[form], value) is not None


def _checked(value: Any, default: Any, info: ParamInfo) -> Tuple[Any, str]:
    if isinstance(default, tuple):
        if not isinstance(value, (list, tuple)):
            return value, "must be a list"
        items = [_checked(item, default[0] if default else item, info) for item in value]
        return tuple(item for item, _ in items), "; ".join(fault for _, fault in items if fault)
    kind = type(default)
    if kind is str and isinstance(value, bool) and str(value).lower() in (info.choices or ()):
        value = str(value).lower()  # YAML reads a plain true as a bool
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if type(value) is not kind:
        return value, f"must be of type {kind.__name__}"
    if info.choices is not None and value not in info.choices and not has_form(value, info.form):
        return value, f"must be {info.allowed}"
    if kind in (int, float) and not (
        math.isfinite(value) and (info.low is None or value >= info.low) and (info.high is None or value <= info.high)
    ):
        unit = f" {info.unit}" if info.unit else ""
        return value, f"must be finite and within {info.allowed}{unit}"
    return value, ""
