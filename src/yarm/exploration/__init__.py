"""One robot maps an unknown room by itself: controllers that turn what is observed into a command at 10 Hz."""
