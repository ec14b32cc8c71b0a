"""The program ``hil``: the console script of the wheel, and the process that guards a bench of hardware beside it."""

from __future__ import annotations

import signal
import sys
from typing import NoReturn

from palpate import _palpate


def main() -> NoReturn:
    """Runs the command line as the program ``hil`` does, and exits with its status."""
    # The program ends itself in order; Python's own handler would wait for it to return.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # By this file and not by ``-m``, which would look for modules in the folder that the user is in.
    again = [sys.executable, __file__]
    sys.exit(_palpate.main(["hil", *sys.argv[1:]], again))


if __name__ == "__main__":
    main()
