"""What a campaign has done: a line a block of seeds, so that one that ended goes on."""

import dataclasses
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from tests.adversary.cases import Claim, Outcome

# Seeds of a block: what is lost at most when a campaign is ended.
_BLOCK = 20


def blocks(seeds: range) -> Iterator[range]:
    """Yield the seeds in blocks that begin at multiples of their size, whatever the first seed."""
    begin = seeds.start
    while begin < seeds.stop:
        end = min(seeds.stop, (begin // _BLOCK + 1) * _BLOCK)
        yield range(begin, end)
        begin = end


@dataclass(frozen=True)
class Done:
    """What became of a block, and how long that took [s of the processor]."""

    outcome: Outcome
    seconds: float

    @property
    def claims(self) -> list[Claim]:
        return [*self.outcome.wrong, *self.outcome.refused]


@dataclass
class CampaignLog:
    """Blocks that are done, by kind and seeds; without a file it only remembers them."""

    file: Path | None
    known: dict[tuple[str, int, int], Done] = field(default_factory=dict)

    @classmethod
    def read(cls, file: Path | None) -> "CampaignLog":
        """Return what a file has; a last line that was cut off counts as none."""
        log = cls(file)
        text = file.read_text() if file is not None and file.exists() else ""
        for line in text.splitlines(keepends=True):
            if line.endswith("\n"):
                kind, first, last, entry = json.loads(line)
                log.known[kind, first, last] = _done(entry)
        if file is not None and text and not text.endswith("\n"):
            file.write_text(text[: text.rfind("\n") + 1])
        return log

    def get(self, kind: str, seeds: range) -> Done | None:
        return self.known.get((kind, seeds.start, seeds.stop))

    def put(self, kind: str, seeds: range, outcome: Outcome, seconds: float) -> Done:
        done = Done(outcome, seconds)
        self.known[kind, seeds.start, seeds.stop] = done
        if self.file is not None:
            entry = [kind, seeds.start, seeds.stop, dataclasses.asdict(done)]
            with self.file.open("a") as log:
                log.write(json.dumps(entry) + "\n")
        return done


def _done(entry: dict) -> Done:
    told = entry["outcome"]
    wrong, refused = ([Claim(**claim) for claim in told[name]] for name in ("wrong", "refused"))
    return Done(Outcome(wrong, refused, told["counts"]), entry["seconds"])
