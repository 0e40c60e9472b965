"""Brings the graph up: its processes, who is there, and the parameters they have."""
