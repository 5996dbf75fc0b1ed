"""The program `gen`: `python -m sheetlight` and the console script of that name."""

import os
import sys

from sheetlight import _sheetlight


def main() -> None:
    """Does what the command line says and ends with its exit status."""
    # `gen check` finds the onnxruntime of the environment that this package is installed in, activated or not.
    os.environ.setdefault("VIRTUAL_ENV", sys.prefix)
    # As the program ends where a pipe that it writes to is closed, and not as Python does.
    status = _sheetlight.run_from(["gen", *sys.argv[1:]])
    sys.stdout.flush()
    os._exit(status)


if __name__ == "__main__":
    main()
