"""Random contacts around the control laws: the evidence for `docs/guarantee.md`."""
