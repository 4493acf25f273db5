"""The carry: robot and person find, lift, carry, turn and set down a panel together."""
