"""The command `tandem`: starts, watches and stops stacks of processes, and speaks to running ones."""
