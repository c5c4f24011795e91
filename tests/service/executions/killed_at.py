"""The service, which kills itself and all its workers at the instant that `KILLED_AT` says.

`python -m tests.service.executions.killed_at serve ...`
"""

import os
import signal

from service.__main__ import main
from service.executions.gripping import grasp_keeper
from service.jobs.event_buffer import EventBuffer
from tests.service.servers import living

# Before the last statuses are recorded; before and after the scene has what is held.
INSTANTS = ("unrecorded", "unattached", "attached")


def die():
    """Kill every process below this one, and this one."""
    parents = living()
    below = {os.getpid()}
    while grown := {child for child, parent in parents.items() if parent in below} - below:
        below |= grown
    for process in sorted(below - {os.getpid()}):
        os.kill(process, signal.SIGKILL)
    os.kill(os.getpid(), signal.SIGKILL)


def sabotage(instant):
    edit = grasp_keeper.apply_edits

    async def edited_and_dead(*arguments, **named):
        if instant == "attached":
            await edit(*arguments, **named)
        die()

    async def dead(_self):
        die()

    if instant == "unrecorded":
        EventBuffer.flush = dead
    else:
        grasp_keeper.apply_edits = edited_and_dead


if __name__ == "__main__":
    sabotage(os.environ["KILLED_AT"])
    main()
