"""YARM: see the cell as a live occupancy grid, decide who reaches which debris, move the fleet without touching."""
