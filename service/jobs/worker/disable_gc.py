"""What the forkserver imports first: from here on it does not look for garbage.

What it imports lasts as long as it does; to look for garbage among it takes a tenth of its start.
Its children look again, but not among what it imported (docs.python.org, `gc.freeze`).
"""

import gc

gc.disable()
