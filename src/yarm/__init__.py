"""YARM: see the cell as a live occupancy grid, decide who reaches which debris, move the fleet without touching."""

from pkgutil import extend_path

# The generated messages (yarm.msg, yarm.srv) are built into another folder of the same package.
__path__ = extend_path(__path__, __name__)
