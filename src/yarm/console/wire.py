"""What goes to a page: one binary message each, a header in JSON and arrays behind it.

    b"YRM1" | length of the header, uint32 | header | padding to 4 bytes | arrays, each padded to 4 bytes

Little-endian. The header's ``arrays`` has for each array its name, type (``f4``, ``u2``, ``u1``), shape and where it
begins, bytes from the end of the header's padding.
"""

from __future__ import annotations

import json
import struct
from typing import Any, Dict, List, Mapping, Tuple

import numpy as np
import numpy.typing as npt

MAGIC = b"YRM1"
TYPES = ("f4", "u2", "u1")
Array = npt.NDArray[Any]


def encode(header: Mapping[str, Any], arrays: Mapping[str, Array]) -> bytes:
    """One message.

    Args:
        header: what JSON can say; numbers that are not finite must not be in it.
        arrays: float32, uint16 or uint8, by name.

    Raises:
        ValueError: a number that is not finite, or an array of another type.
    """
    listed, blocks, at = [], [], 0
    for name, array in arrays.items():
        kind = array.dtype.newbyteorder("<").str[1:]
        if kind not in TYPES:
            raise ValueError(f"array {name}: type {array.dtype} must be one of {', '.join(TYPES)}")
        block = _padded(np.ascontiguousarray(array, dtype=f"<{kind}").tobytes())
        listed.append({"name": name, "type": kind, "shape": list(array.shape), "at": at})
        blocks.append(block)
        at += len(block)
    words = json.dumps({**header, "arrays": listed}, allow_nan=False, separators=(",", ":")).encode()
    return b"".join([MAGIC, struct.pack("<I", len(words)), _padded(words), *blocks])


def decode(message: bytes) -> Tuple[Dict[str, Any], Dict[str, Array]]:
    """Header and arrays of a message.

    Raises:
        ValueError: it is none.
    """
    if message[:4] != MAGIC:
        raise ValueError(f"a message begins with {message[:4]!r}, expected {MAGIC!r}")
    (length,) = struct.unpack_from("<I", message, 4)
    header = json.loads(message[8 : 8 + length])
    base = 8 + length + (-length) % 4
    arrays = {}
    for entry in header.pop("arrays"):
        count = int(np.prod(entry["shape"]))
        flat: Array = np.frombuffer(message, f"<{entry['type']}", count, base + entry["at"])
        arrays[entry["name"]] = flat.reshape(entry["shape"])
    return header, arrays


def pieces_of(message: bytes) -> List[bytes]:
    """A message cut in front of each of its arrays; put together again the pieces are the message."""
    (length,) = struct.unpack_from("<I", message, 4)
    base = 8 + length + (-length) % 4
    cuts = [0, *(base + entry["at"] for entry in json.loads(message[8 : 8 + length])["arrays"]), len(message)]
    return [message[a:b] for a, b in zip(cuts, cuts[1:])]


def _padded(data: bytes) -> bytes:
    return data + b"\0" * (-len(data) % 4)
