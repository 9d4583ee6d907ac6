"""The command ``willis``: the same program as the binary, in this process."""

from __future__ import annotations

import sys

from . import _willis


def main() -> int:
    """Runs the command line and returns its exit status."""
    return _willis.main(["willis", *sys.argv[1:]])
