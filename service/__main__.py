"""Entry point of `wayproof` and `python -m service`.

Workers import this module again (multiprocessing's forkserver does), so it imports next to nothing.
"""

import os
import sys


def main() -> None:
    """Run the command line."""
    # The matrices here are tiny: threads of a BLAS spin beside them, and a retiming takes six times
    # the processor's time. Parallel work is done by processes. Read when numpy is first imported.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from service.workers import serves_with_processes, start_to_import  # noqa: PLC0415

    if serves_with_processes(sys.argv[1:], os.environ):
        start_to_import()
    from service.cli.app import app  # noqa: PLC0415  (kept out of workers)

    app()


if __name__ == "__main__":
    main()
