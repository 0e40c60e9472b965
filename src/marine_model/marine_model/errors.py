"""Exceptions of the whole stack: one root, so that a caller may catch all of ours with one clause."""

from __future__ import annotations


class DpError(Exception):
    """Root of every error this project raises on purpose."""


class InputError(DpError, ValueError):
    """A value handed to a core has the wrong shape, is not finite, or lies outside its range.

    The message always names the quantity, what was expected and what was found.
    """


class DocumentError(DpError, ValueError):
    """A YAML document (vessel, scenario) is missing, unreadable or contradicts its schema.

    The message has one line per problem: file, line, field, what was expected, what was found.
    """


class UnknownNameError(DocumentError):
    """A vessel or scenario name is not among the known ones; the message lists them."""
