"""The robustness sweep of the carrying task: many different carries in simulated time, judged by ground truth."""
