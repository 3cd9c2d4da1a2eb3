"""The youBot clears a floor by itself: where it stands, how it reaches, the way between, and the work in order."""
