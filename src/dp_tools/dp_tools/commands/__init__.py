"""One module a command of `dp`."""
