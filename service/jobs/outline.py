"""Outline: what is left of a job's content where many jobs are listed.

Trajectories, graphs and faces of regions are megabytes; a list shows none of them, and so does not
read them. An outline is the content without its large members, everything else in its place: who
reads the one can read the other.
"""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Outline:
    """The large members of what a task is given and gives, as dotted names of members.

    Attributes:
        payload: Of its payload.
        result: Of what it returns.
        failure: Of how it failed.
    """

    payload: tuple[str, ...] = ()
    result: tuple[str, ...] = ()
    failure: tuple[str, ...] = ()


def without(content: Any, members: tuple[str, ...]) -> Any:
    """Return content without some members, which need not be there; the content itself stays."""
    for member in members:
        first, _, rest = member.partition(".")
        if not isinstance(content, dict) or first not in content:
            continue
        inner: Any = without(content[first], (rest,)) if rest else None
        kept = {name: item for name, item in content.items() if name != first}
        content = {**kept, first: inner} if rest else kept
    return content
