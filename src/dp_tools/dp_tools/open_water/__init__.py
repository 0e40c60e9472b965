"""Trials in open water: one thruster by itself in a basin, and several ways to control it compared."""
