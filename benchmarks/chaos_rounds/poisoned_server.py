"""Poisoned server: `wayproof`, with workers that some plans break (`poison`).

Workers import this module again, so it imports next to nothing.
"""

from service import workers
from service.__main__ import main

workers.PRELOAD = (*workers.PRELOAD, "benchmarks.chaos_rounds.poison")

if __name__ == "__main__":
    main()
