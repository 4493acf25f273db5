"""The Zenoh router that the other processes meet at."""
