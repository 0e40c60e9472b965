"""Other ways to allocate thrust, each given the same steps: what users would pick instead."""
