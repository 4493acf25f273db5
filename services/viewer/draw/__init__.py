"""Messages as pictures: pure towards rerun, which is given as a stream."""
