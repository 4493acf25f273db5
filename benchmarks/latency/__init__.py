"""Sources, relays and sinks whose latencies `benchmarks.chain` compares."""
