"""The program ``lightmesh``, as ``python -m lightmesh`` and as the script of the wheel."""

import importlib
import signal
import sys

from lightmesh._native import _run_program

#: Commands that are written in Python, each with the module whose ``main(arguments) -> exit code`` it is. All others are Rust's.
COMMANDS: dict[str, str] = {"farm": "lightmesh.farm"}


def main() -> int:
    """Runs the command line that Python was started with, and returns its exit code."""
    arguments = sys.argv[1:]
    if arguments and arguments[0] in COMMANDS:
        code: int = importlib.import_module(COMMANDS[arguments[0]]).main(arguments[1:])
        return code
    # Ctrl-C is the program's own affair: Python would only hear of it when all is done.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _run_program(["lightmesh", *arguments])


if __name__ == "__main__":
    sys.exit(main())
