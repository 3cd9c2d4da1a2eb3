"""Planning scenes, instances with known answers, and stepping a scene to its end."""
