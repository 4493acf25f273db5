"""The force-limiting controller: from wrench, pose and target to a tool twist that keeps the stated limits."""
