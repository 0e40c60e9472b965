"""The quadratic program of one step as an object, and what solves it."""
