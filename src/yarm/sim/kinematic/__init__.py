"""A TurtleBot in an arena without physics: exact contact of a disc, exact rays, noise; a millisecond a tick."""
