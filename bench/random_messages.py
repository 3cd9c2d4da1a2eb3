"""Messages of any ROS type filled with anything that can be sent: absurd numbers, wrong lengths, names nobody has.

    message = random_message(JointState, random.Random(1), names=("hc10_barc",), now_s=12.0)

The draws come from a ``random.Random``; hypothesis's ``randoms()`` is one, whose failures it makes smaller.
"""

from __future__ import annotations

import math
import random
import struct
from typing import Any, Callable, Dict, Sequence, Tuple, Type

import genpy
import roslib.message

WHOLE: Dict[str, Tuple[int, int]] = {
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
    "byte": (-128, 127),
    "char": (0, 255),
}
BAD = (math.inf, -math.inf, math.nan, 1e300, -1e300, 1e38, -1e12, 1e9, 1e4, 0.0, -0.0, -1.0, 1e-300)
LENGTHS = (0, 0, 1, 1, 2, 3, 4, 6, 7, 40)
WORDS = (
    "",
    "world",
    "/",
    "Debris",
    "Mobile",
    "Obstacle",
    "true",
    "CALIBRATION",
    "ON",
    "x",
    "a" * 300,
    "\u00e9\n\0",
    "..",
)
BYTES = 200
DEEPEST = 6
LATEST_S = 2.0**31 - 1.0
MUTATED_SHARE = 0.5
"""How often bytes are changed after the message was written."""


def random_message(kind: Type[Any], rng: random.Random, names: Sequence[str] = (), now_s: float = 0.0) -> Any:
    """A message, or the request of a service, with everything at random.

    Args:
        kind: its class.
        rng: the draws.
        names: texts that mean something to who reads it, in half of all texts.
        now_s: stamps are often near this, s.
    """
    return _filled(kind, rng, (*names, *WORDS), now_s, 0)


def random_bytes(message: Any, rng: random.Random) -> bytes:
    """A message as it goes over the wire; in half of all cases with some bytes changed, left out or added."""
    buffer = _Buffer()
    message.serialize(buffer)
    data = bytearray(buffer.data)
    if rng.random() >= MUTATED_SHARE:
        return bytes(data)
    for _ in range(rng.randint(1, 4)):
        at = rng.randint(0, max(0, len(data) - 1))
        change = rng.randint(0, 2)
        if change == 0 and data:
            data[at] = rng.randint(0, 255)
        elif change == 1:
            del data[at : at + rng.randint(1, 8)]
        else:
            data[at:at] = struct.pack("<I", rng.choice((0, 1, 7, 2**16, 2**31, 2**32 - 1)))
    return bytes(data)


class _Buffer:
    def __init__(self) -> None:
        self.data = b""

    def write(self, data: bytes) -> None:
        self.data += data


def _filled(kind: Type[Any], rng: random.Random, words: Sequence[str], now_s: float, depth: int) -> Any:
    message = kind()
    for slot, slot_type in zip(kind.__slots__, kind._slot_types):
        setattr(message, slot, _value(slot_type, rng, words, now_s, depth))
    return message


def _value(slot_type: str, rng: random.Random, words: Sequence[str], now_s: float, depth: int) -> Any:
    if slot_type.endswith("]"):
        return _array(*slot_type[:-1].split("["), rng, words, now_s, depth)
    single: Dict[str, Callable[[], Any]] = {
        "float32": lambda: _number(rng, True),
        "float64": lambda: _number(rng, False),
        "bool": lambda: rng.random() < 0.5,
        "string": lambda: rng.choice(words),
        "time": lambda: _time(genpy.Time, rng, now_s),
        "duration": lambda: _time(genpy.Duration, rng, now_s),
        **{kind: lambda: _whole(*WHOLE[slot_type], rng) for kind in WHOLE},
    }
    if slot_type in single:
        return single[slot_type]()
    return _filled(roslib.message.get_message_class(slot_type), rng, words, now_s, depth + 1)


def _array(element: str, length: str, rng: random.Random, words: Sequence[str], now_s: float, depth: int) -> Any:
    count = int(length) if length else (0 if depth >= DEEPEST else rng.choice(LENGTHS))
    if element in ("uint8", "char"):
        return bytes(rng.randint(0, 255) for _ in range(count if length else count * rng.randint(0, BYTES // 8)))
    return [_value(element, rng, words, now_s, depth + 1) for _ in range(count)]


def _whole(low: int, high: int, rng: random.Random) -> int:
    near = rng.randint(max(low, -2), min(high, 8))
    return rng.choice((near, near, low, high))


def _number(rng: random.Random, single: bool) -> float:
    if rng.random() < 0.3:
        value = rng.choice(BAD)
        return math.copysign(math.inf, value) if single and abs(value) > 3e38 else value
    return rng.choice((rng.uniform(-3.0, 3.0), rng.uniform(-1.0, 1.0), 1.0, 0.0))


def _time(kind: Any, rng: random.Random, now_s: float) -> Any:
    seconds = rng.choice((now_s, now_s, now_s + 0.1, now_s - 1.0, now_s + 1e4, 0.0, LATEST_S))
    return kind.from_sec(min(max(0.0, seconds), LATEST_S))
