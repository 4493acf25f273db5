"""What turns a service into a process: the loop, its health, its configuration."""
