"""Ways to allocate without a program to solve: pseudo-inverse, azimuth angle in common, portions."""

from thrust_allocator.methods.make import check_method, default_moment, knows_speed, make_method
from thrust_allocator.methods.method import Method, MethodReport, Wanted

__all__ = [
    "Method",
    "MethodReport",
    "Wanted",
    "check_method",
    "default_moment",
    "knows_speed",
    "make_method",
]
