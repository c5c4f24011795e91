"""Task: a piece of work that workers do, by a stable name, with models of what goes in and out.

A task is declared where the server can import it, without Drake, and carried out by the function of
a worker module that `Task.runs` decorates. Jobs are stored with its name: a module may move.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict

from service.jobs.context import TaskContext
from service.jobs.json_text import Encoded, with_parts
from service.jobs.outline import Outline

type _Function = Callable[[Any, TaskContext], BaseModel]

_tasks: dict[str, "Task[Any, Any]"] = {}
_NOTHING_LARGE = Outline()


class TaskModel(BaseModel):
    """What a task is given or returns, where no request or answer is its model.

    Attributes:
        artifact_members: Of what is given, the members that name artifacts which it reads, as
            dotted names, of all items where one is a list; one that is null names none.
    """

    artifact_members: ClassVar[tuple[str, ...]] = ()

    model_config = ConfigDict(frozen=True)


class UnknownTask(LookupError):
    """There is no task of that name, or no module that was imported carries it out."""


@dataclass(frozen=True)
class TaskResult:
    """What a task returned, as JSON.

    Attributes:
        text: All of it.
        summary: What lists show of it; empty for all.
    """

    text: str
    summary: str = ""


class Task[In: BaseModel, Out: BaseModel]:
    """A piece of work that workers do.

    Attributes:
        name: By which jobs are stored; it never changes.
        payload: The model of what it is given.
        result: The model of what it returns.
        queue: Where it waits for a worker.
        max_attempts: How often it may be run if its process dies.
        outline: What is large in its payload, result and failure.
    """

    def __init__(
        self,
        name: str,
        payload: type[In],
        result: type[Out],
        *,
        queue: str = "query",
        max_attempts: int = 2,
        outline: Outline | None = None,
    ) -> None:
        """Declare a task.

        Raises:
            ValueError: There is another one of that name.
        """
        if name in _tasks:
            message = f"there are two tasks {name!r}"
            raise ValueError(message)
        self.name = name
        self.payload = payload
        self.result = result
        self.queue = queue
        self.max_attempts = max_attempts
        self.outline = outline or Outline()
        self._function: _Function | None = None
        _tasks[name] = self

    def runs(self, function: Callable[[In, TaskContext], Out]) -> Callable[[In, TaskContext], Out]:
        """Have a function carry the task out, in every process that imports its module."""
        self._function = function
        return function

    def run(self, payload: str, context: TaskContext) -> TaskResult:
        """Carry it out with a payload in JSON.

        Raises:
            UnknownTask: No module that was imported does.
            ValidationError: The payload is not what its model says.
        """
        if self._function is None:
            message = f"no module that was imported carries out the task {self.name!r}"
            raise UnknownTask(message)
        found = self._function(self.payload.model_validate_json(payload), context)
        large = self.outline.result
        if not large:
            return TaskResult(text_of(found))
        apart = dict.fromkeys(member.partition(".")[0] for member in large)
        parts = {name: Encoded(_member(found, name)) for name in apart}
        plain = text_of(found, exclude=set(apart))
        summary = plain if set(large) == set(apart) else text_of(found, exclude=_nested(large))
        return TaskResult(with_parts(plain, parts), summary)


def task_named(name: str) -> Task[Any, Any]:
    """Return a task by its name.

    Raises:
        UnknownTask: There is none.
    """
    found = _tasks.get(name)
    if found is None:
        message = f"there is no task {name!r}; tasks: {sorted(_tasks)}"
        raise UnknownTask(message)
    return found


def outline_of(task: str) -> Outline:
    """Return the outline of what a task is given and gives; nothing is large in one not known."""
    found = _tasks.get(task)
    return _NOTHING_LARGE if found is None else found.outline


def artifacts_of(task: str, payload: Mapping[str, Any]) -> list[str]:
    """Return which artifacts a task reads that is given a payload."""
    known = _tasks.get(task)
    members: tuple[str, ...] = getattr(known and known.payload, "artifact_members", ())
    named = [reduce(_inner, member.split("."), [payload]) for member in members]
    return list(dict.fromkeys(text for each in named for text in each if isinstance(text, str)))


def _inner(contents: list[Any], name: str) -> list[Any]:
    """Return the members of a name of all contents; of a member that is a list, its items."""
    found = [content.get(name) for content in contents if isinstance(content, Mapping)]
    return [item for member in found for item in (member if isinstance(member, list) else [member])]


def text_of(content: BaseModel, **selection: Any) -> str:
    """Return the JSON of a model in ASCII, which every database can hold."""
    # To look whether it is ASCII, as it mostly is, is quicker than to escape as it is written.
    text = content.model_dump_json(**selection)
    return text if text.isascii() else content.model_dump_json(ensure_ascii=True, **selection)


def _member(content: BaseModel, name: str) -> str:
    """Return the JSON of one member of a model, which may be text already."""
    found = getattr(content, name)
    if isinstance(found, Encoded):
        return found.text
    return text_of(content, include={name})[len(f'{{"{name}":') : -1]


def _nested(members: tuple[str, ...]) -> Mapping[str, Any]:
    """Return dotted names of members as pydantic excludes them."""
    nested: dict[str, Any] = {}
    for member in members:
        first, _, rest = member.partition(".")
        if not rest:
            nested[first] = True
        elif nested.get(first) is not True:
            nested.setdefault(first, {})[rest] = True
    return nested
