"""DatabaseTimeouts: how long a database is waited for."""

from dataclasses import dataclass


@dataclass(frozen=True)
class DatabaseTimeouts:
    """How long a database is waited for; `takeover` bounds how long two servers move one robot.

    Attributes:
        period: Between two looks at the lock [s].
        answer: For the database to answer [s].
        regain: For the lock, before what runs is brought to its end [s].
        rest: For what runs to come to its end [s].
        record: For a new job to be written, before it is refused [s].
        patience: For a leader to take a lock again that it has lost, before a follower does [s].
        poll: Between two looks of the leader at the table for what it was not notified of [s].
        tables: For another server to make or to change the tables, while this one starts [s].
    """

    period: float = 1.0
    answer: float = 2.0
    regain: float = 5.0
    rest: float = 6.0
    record: float = 5.0
    patience: float = 5.0
    poll: float = 5.0
    tables: float = 10.0

    @property
    def takeover(self) -> float:
        """How long after its loss of the lock an owner may still have something that runs [s]."""
        return self.period + 2 * self.answer + self.regain + self.rest
