"""Occupancy grids in files: an image (PGM) and a YAML beside it, in the format of ``map_server``.

Writing gives 8-bit binary PGM (P5) with 254 for free, 0 for occupied and 205 for unknown, the top row first. Reading
takes binary and plain PGM of up to 8 bits and every key of the format. A file is written whole or not at all.
"""

from __future__ import annotations

import math
import os
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry.poses import Pose2
from yarm.navigation.grid_map import FREE_AT_MOST, OCCUPIED_AT_LEAST, CellArray, GridMap
from yarm.yaml_fields import Faults, Fields, SceneError, load_yaml

ShadeArray = npt.NDArray[np.uint8]

FREE_SHADE, UNKNOWN_SHADE, OCCUPIED_SHADE = 254, 205, 0
OCCUPIED_THRESH, FREE_THRESH = "0.65", "0.196"
"""What every written YAML says: between them lie the shades of cells that are neither; 205 is one of them."""
MODES = ("trinary", "scale", "raw")
MOST_CELLS = 1 << 26
"""Most cells of a map that is read."""
FARTHEST_M = 1e5
"""A map's origin lies within this of its frame's, metres."""


class MapFileError(ValueError):
    """A map cannot be read or written; the message says which file, what is wrong with it and what was expected."""


@dataclass(frozen=True)
class SavedMap:
    """The two files of a map."""

    image: Path
    description: Path


@dataclass(frozen=True)
class _Description:
    """What a map's YAML says."""

    image: Path
    resolution_m: float
    origin: Pose2
    negate: bool
    occupied: float
    free: float
    mode: str


def thresholds_fault(occupied: int, free: int) -> str:
    """What is wrong with two thresholds of cell values; empty when they can be used."""
    if not 1 <= occupied <= 100:
        return f"the occupied threshold is {occupied}, expected 1 to 100"
    if not 0 <= free < occupied:
        return f"the free threshold is {free}, expected at least 0 and below the occupied threshold, {occupied}"
    return ""


def paths(name: Path) -> SavedMap:
    """The files of a map of this name: NAME.pgm and NAME.yaml."""
    return SavedMap(name.with_name(f"{name.name}.pgm"), name.with_name(f"{name.name}.yaml"))


def writing_fault(name: Path) -> str:
    """Why a map of this name could not be written, found out by writing a few bytes beside it; empty when it could."""
    probe = _part_of(paths(name).image)
    try:
        _write_part(probe, b"yarm")
    except OSError as error:
        return _cannot_write(paths(name).image, error)
    finally:
        _drop(probe)
    return ""


def write_map(grid: GridMap, name: Path, occupied: int = OCCUPIED_AT_LEAST, free: int = FREE_AT_MOST) -> SavedMap:
    """Write NAME.pgm and NAME.yaml, each by way of a file beside it that takes its name when it is safely on the disk.

    Args:
        grid: values -1 (unknown) and 0 to 100.
        name: path without a suffix.
        occupied: from this value on a cell is occupied.
        free: up to this value a cell is free.

    Raises:
        MapFileError: thresholds that cannot be used, or a file that cannot be written; older files then stay.
    """
    fault = thresholds_fault(occupied, free)
    if fault:
        raise MapFileError(fault)
    files = paths(name)
    contents = {
        files.image: pgm_bytes(grid, occupied, free),
        files.description: yaml_text(grid, files.image.name).encode(),
    }
    try:
        for path, content in contents.items():
            _write_part(_part_of(path), content)
        for path in contents:
            _part_of(path).replace(path)
        _sync_folder(name.parent)
    except OSError as error:
        raise MapFileError(_cannot_write(files.image, error)) from error
    finally:
        for path in contents:
            _drop(_part_of(path))
    return files


def pgm_bytes(grid: GridMap, occupied: int = OCCUPIED_AT_LEAST, free: int = FREE_AT_MOST) -> bytes:
    """The image of a grid."""
    values = np.flipud(grid.cells)
    shades = np.full(values.shape, UNKNOWN_SHADE, np.uint8)
    shades[(values >= 0) & (values <= free)] = FREE_SHADE
    shades[values >= occupied] = OCCUPIED_SHADE
    rows, columns = shades.shape
    return (
        f"P5\n# CREATOR: yarm map_saver {grid.resolution_m:.3f} m/pix\n{columns} {rows}\n255\n".encode()
        + shades.tobytes()
    )


def yaml_text(grid: GridMap, image: str) -> str:
    """The YAML of a grid whose image is a file of this name in the same folder."""
    origin = grid.origin
    return (
        f"image: {image}\nresolution: {grid.resolution_m:f}\n"
        f"origin: [{origin.x:f}, {origin.y:f}, {origin.yaw_rad:f}]\n"
        f"negate: 0\noccupied_thresh: {OCCUPIED_THRESH}\nfree_thresh: {FREE_THRESH}\n\n"
    )


def read_map(path: Path) -> GridMap:
    """The grid that a YAML and its image hold: values -1, 0 and 100; 1 to 99 as well in the modes scale and raw.

    Raises:
        MapFileError: no such file, a key missing or wrong, an image that is none or not whole; every fault is listed.
    """
    found = _read_description(path)
    try:
        shades = parse_pgm(found.image.read_bytes(), str(found.image))
    except OSError as error:
        raise MapFileError(
            f"{path}: image = {str(found.image)!r}: expected a PGM file that can be read: {error}"
        ) from error
    return GridMap(np.ascontiguousarray(np.flipud(_values(shades, found))), found.resolution_m, found.origin)


def parse_pgm(data: bytes, file: str) -> ShadeArray:
    """Shades (rows, columns), 0 to 255, top row first, of a PGM, binary (P5) or plain (P2), of at most 8 bits.

    Raises:
        MapFileError: it is none, or not whole.
    """
    kind, sizes, start = _pgm_head(data, file)
    columns, rows, white = sizes
    if not (columns > 0 and rows > 0 and columns * rows <= MOST_CELLS):
        raise MapFileError(f"{file}: size = {columns} x {rows}: expected 1 to {MOST_CELLS} cells")
    if not 0 < white < 256:
        raise MapFileError(f"{file}: largest shade = {white}: expected 1 to 255 (8 bits)")
    body = data[start : start + columns * rows] if kind == b"P5" else _plain_shades(data[start:], file)
    if len(body) < columns * rows:
        raise MapFileError(
            f"{file}: holds {len(body)} shades: expected {columns} x {rows} = {columns * rows}; cut off?"
        )
    shades = np.frombuffer(body, np.uint8, columns * rows).reshape(rows, columns)
    if int(shades.max()) > white:
        raise MapFileError(
            f"{file}: a shade of {int(shades.max())}: expected at most {white}, the largest it announces"
        )
    return shades if white == 255 else np.rint(shades * (255.0 / white)).astype(np.uint8)


def _pgm_head(data: bytes, file: str) -> Tuple[bytes, Tuple[int, int, int], int]:
    """Kind, (columns, rows, largest shade) and where the shades begin; comments may stand between the numbers."""
    gap = rb"(?:\s|#[^\n]*\n)+"
    head = re.match(rb"(P[25])" + gap + rb"(\d{1,9})" + gap + rb"(\d{1,9})" + gap + rb"(\d{1,9})\s", data[:10_000])
    if head is None:
        raise MapFileError(f"{file}: begins with {data[:12]!r}: expected a PGM: P5 or P2, width, height, largest shade")
    return head.group(1), (int(head.group(2)), int(head.group(3)), int(head.group(4))), head.end()


def _plain_shades(text: bytes, file: str) -> bytes:
    try:
        return bytes(int(word) for word in re.sub(rb"#[^\n]*", b"", text).split())
    except ValueError as error:
        raise MapFileError(f"{file}: holds what is no shade: expected whole numbers 0 to 255: {error}") from error


def _values(shades: ShadeArray, found: _Description) -> CellArray:
    """Values of cells, as the format defines them for each mode."""
    values = np.full(shades.shape, -1, np.int8)
    if found.mode == "raw":
        raw = 255 - shades if found.negate else shades
        values[raw <= 100] = raw[raw <= 100]
        return values
    darkness = (shades if found.negate else 255 - shades.astype(np.float64)) / 255.0
    if found.mode == "scale":
        values[...] = 1 + 98 * np.clip((darkness - found.free) / (found.occupied - found.free), 0.0, 1.0)
    values[darkness > found.occupied] = 100
    values[darkness < found.free] = 0
    return values


def _read_description(path: Path) -> _Description:
    """What a map's YAML says; keys that the format does not know are left alone, as others' readers do."""
    faults = Faults(str(path))
    try:
        fields = Fields(load_yaml(path), "", faults)
        image = fields.text("image")
        resolution_m = fields.number("resolution", 1e-3, 100.0, "m")
        x, y, yaw_rad = _origin(fields, faults)
        negate = fields.value("negate", "0 or 1", required=True)
        if fields.has("negate") and not (isinstance(negate, int) and negate in (0, 1)):
            faults.add("negate", negate, "0 or 1")
        occupied = fields.number("occupied_thresh", 0.0, 1.0, "")
        free = fields.number("free_thresh", 0.0, 1.0, "")
        if free >= occupied and not faults.lines:
            faults.add("free_thresh", free, f"less than occupied_thresh, {occupied:g}")
        mode = fields.text("mode", MODES[0], MODES)
        faults.raise_if_any()
    except SceneError as error:
        raise MapFileError(str(error)) from error
    return _Description(path.parent / image, resolution_m, Pose2(x, y, yaw_rad), bool(negate), occupied, free, mode)


def _origin(fields: Fields, faults: Faults) -> Tuple[float, float, float]:
    x, y, yaw_rad = fields.numbers("origin", 3, -FARTHEST_M, FARTHEST_M)
    if fields.has("origin") and abs(yaw_rad) > 2.0 * math.pi:
        faults.add("origin", fields.raw["origin"], "a yaw within -2 pi to 2 pi rad; is it in degrees?")
    return x, y, yaw_rad


def _cannot_write(path: Path, error: OSError) -> str:
    return (
        f"{path} cannot be written: {error.strerror or error}; is {path.parent} a folder with room and leave to write?"
    )


def _part_of(path: Path) -> Path:
    """The file that grows until it takes the other's name; one for each process."""
    return path.with_name(f".{path.name}.{os.getpid()}.part")


def _write_part(path: Path, content: bytes) -> None:
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _drop(path: Path) -> None:
    with suppress(OSError):
        path.unlink()


def _sync_folder(folder: Path) -> None:
    """Have the new names on the disk too."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
