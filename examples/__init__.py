"""Short programs to begin with: a controller, a script and a robot of one's own, on the stack as it is."""
