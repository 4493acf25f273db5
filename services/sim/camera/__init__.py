"""The simulated head camera: what there is to see, rendered on the processor."""
