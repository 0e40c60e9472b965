"""Speed and size of the stack, against aims and peers: `python -m benchmarks`, described in docs/benchmarks.md."""
