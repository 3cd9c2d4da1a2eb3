"""Grid, poses, masks and column images; NumPy only."""

from yarm.geometry.cell_map import STRAY, CarriedPiece, CellMap, CellState, MappedObject, SeenPiece, Visibility
from yarm.geometry.columns import (
    ColumnImage,
    cells_from_columns,
    columns_from_cells,
    columns_from_grid,
    dilated,
    grid_from_columns,
    shifted,
)
from yarm.geometry.grid import BoolArray, FloatArray, GridError, GridSpec, IntArray
from yarm.geometry.masks import Mask
from yarm.geometry.poses import (
    Pose2,
    pairs,
    quaternion_from_rpy,
    rotation_of_quaternion,
    rpy_of_quaternion,
    transform_matrix,
    transform_points,
    wrap_angle,
    yaw_of_quaternion,
)

__all__ = [
    "STRAY",
    "BoolArray",
    "CarriedPiece",
    "CellMap",
    "CellState",
    "ColumnImage",
    "FloatArray",
    "GridError",
    "GridSpec",
    "IntArray",
    "MappedObject",
    "Mask",
    "Pose2",
    "SeenPiece",
    "Visibility",
    "cells_from_columns",
    "columns_from_cells",
    "columns_from_grid",
    "dilated",
    "grid_from_columns",
    "pairs",
    "quaternion_from_rpy",
    "rotation_of_quaternion",
    "rpy_of_quaternion",
    "shifted",
    "transform_matrix",
    "transform_points",
    "wrap_angle",
    "yaw_of_quaternion",
]
