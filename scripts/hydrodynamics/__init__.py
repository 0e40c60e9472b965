"""Motion and mean drift of a hull in waves, from potential flow; run as ``python scripts/hydrodynamics VESSEL``.

Needs the packages of locks/hydrodynamics.txt; ``make hydrodynamics`` installs them. See docs/hydrodynamics.md.
"""
