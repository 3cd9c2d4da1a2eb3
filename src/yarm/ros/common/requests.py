"""Requests that put things into the cell, checked; for whoever serves them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List

from yarm.geometry.kinds import ObjectKind
from yarm.sim.scenes.bodies import SpawnError
from yarm.sim.scenes.scene import MOST_MODEL_BYTES, TOP_M
from yarm.sim.scenes.specs import HALF_CELL_M, ThingSpec

DEFAULT_BOX_M = (0.2, 0.2, 0.2)
UNREGISTERED = "Unregistered"
"""Type of SpawnObstacles for an obstacle that is in no registry."""
UNREGISTERED_DEBRIS = "UnregisteredDebris"
"""And for such a piece of debris."""
SPAWNED_KINDS = {
    ObjectKind.DEBRIS: ObjectKind.DEBRIS,
    ObjectKind.TARGET: ObjectKind.TARGET,
    ObjectKind.OBSTACLE: ObjectKind.OBSTACLE,
    UNREGISTERED: ObjectKind.OBSTACLE,
    UNREGISTERED_DEBRIS: ObjectKind.DEBRIS,
}
"""Kind of body of each type that SpawnObstacles knows."""


def spawn_spec(request: Any, folder: Path) -> ThingSpec:
    """The object a SpawnObstacles request asks for.

    Args:
        request: what is asked.
        folder: of the scene's file; a model's path may be relative to it.

    Raises:
        SpawnError: faults, all listed, with what is accepted.
    """
    faults = []
    if not request.name or not request.name.replace("_", "").isalnum():
        faults.append(f"name {request.name!r} must be letters, digits and underscores")
    if request.type not in SPAWNED_KINDS:
        faults.append(f"type {request.type!r} must be one of {', '.join(SPAWNED_KINDS)}")
    for axis, value, low, high in (
        ("x", request.x, -HALF_CELL_M, HALF_CELL_M),
        ("y", request.y, -HALF_CELL_M, HALF_CELL_M),
        ("z", request.z, 0.0, TOP_M),
        ("yaw", request.yaw, -7.0, 7.0),
    ):
        if not low <= value <= high:
            faults.append(f"{axis} {value} must be within {low:g} to {high:g}")
    size = tuple(request.shape) or DEFAULT_BOX_M
    kind = SPAWNED_KINDS.get(request.type, "")
    boxy = kind == ObjectKind.OBSTACLE and not request.model
    if boxy and (len(size) != 3 or not all(0.01 <= s <= 5.0 for s in size)):
        faults.append(f"shape {list(size)} must be three sizes within 0.01 to 5 m")
    model = str(folder / request.model) if request.model else ""
    if model:
        faults += _model_faults(request, kind, Path(model))
    if faults:
        raise SpawnError("; ".join(faults))
    size = size if boxy else ()
    registered = request.type not in (UNREGISTERED, UNREGISTERED_DEBRIS)
    return ThingSpec(request.name, kind, request.x, request.y, request.z, request.yaw, size, registered, model)


def _model_faults(request: Any, kind: str, file: Path) -> List[str]:
    faults = []
    if kind == ObjectKind.TARGET:
        faults.append(f"model {request.model!r}: a target has no body; leave it empty")
    if request.shape:
        faults.append(f"shape {list(request.shape)} must be empty where a model is given")
    try:
        size = file.stat().st_size if file.is_file() else -1
    except OSError as error:  # for instance, too long a name
        return [*faults, f"model {request.model[:80]!r} cannot be read: {error.strerror}"]
    if size < 0:
        faults.append(f"model {request.model!r} must be a URDF or xacro file; there is no {file}")
    elif size > MOST_MODEL_BYTES:
        faults.append(f"model {request.model!r} has {size} bytes, at most {MOST_MODEL_BYTES}")
    return faults
