"""The HTML report of one run."""

from dp_tools.report.page import write_report
from dp_tools.report.picture import write_picture

__all__ = ["write_picture", "write_report"]
