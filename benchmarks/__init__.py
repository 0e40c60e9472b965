"""Speed and size of the stack, against its aims and its peers: `python -m benchmarks`, described in docs/benchmarks.md."""
