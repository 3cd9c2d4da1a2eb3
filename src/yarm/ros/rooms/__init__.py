"""The node that simulates a room with a TurtleBot in it."""
