"""Clients: one asks for plans, one moves a robot to and fro, and each waits for what it asked."""

import random
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from benchmarks.chaos_rounds.caller import Caller
from benchmarks.chaos_rounds.journal import Asked, Glimpse, Journal
from benchmarks.chaos_rounds.mix import ARM, CONFIGURATIONS, a_plan, to_configuration
from benchmarks.serving.server import pause

# A job that has not ended so long after the last start of a server never will [s]: one that is
# ended twenty times within ten minutes has little time for what waits.
NEVER = 240.0
_PERIOD = 0.1
# A cancel that is recorded ends its job, whatever happens; it is repeated after so long [s].
_LATE = 60.0
# A motion takes a second at 1.
_SPEEDS = (0.1, 0.4, 2.0, 10.0)
# How often a client follows events before it polls.
_FOLLOWED = 0.4
_REFUSALS = frozenset({409})


class Client:
    """Asks for jobs one after another.

    Attributes:
        caller: Asks.
    """

    def __init__(
        self, name: str, caller: Caller, journal: Journal, losses: Callable[[], int]
    ) -> None:
        """Take a name, which keys begin with.

        Args:
            name: Of the client; tells all that it decides by chance.
            caller: Asks.
            journal: Is told.
            losses: Returns how often the server has been killed.
        """
        self.caller = caller
        self._name = name
        self._rng = random.Random(name)
        self._journal = journal
        self._losses = losses
        self._num_asked = 0

    def plan(self, ids: Mapping[str, str]) -> None:
        """Have a plan made, which may have to be canceled.

        Args:
            ids: Of the scenes, by name.
        """
        body, is_endless = a_plan(self._rng, dict(ids))
        wait = self._rng.choice(["", "", "?wait=2"])
        asked, job = self._submit("plan", "/v1/plans", body, wait)
        if is_endless or self._rng.random() < 0.1:
            pause(self._rng.uniform(0.0, 2.0))
            self._cancel(asked)
        if not asked.see(job):
            if not asked.cancels and self._rng.random() < _FOLLOWED:
                self._follow(asked)
            self._await(asked)

    def move(self, scene: str, target: int) -> None:
        """Plan for a robot, carry the plan out, perhaps stop it, and look where it stands.

        Args:
            scene: Of the robot.
            target: Where to, a number of a configuration.
        """
        body = to_configuration(scene, CONFIGURATIONS[target % 3], self._rng)
        plan, job = self._submit("plan", "/v1/plans", body, "?wait=20")
        if not plan.see(job):
            job = self._await(plan)
        if job["state"] != "succeeded":
            return
        wanted = {"plan": plan.id, "speed": self._rng.choice(_SPEEDS)}
        rival = self._rng.random() < 0.3 and threading.Thread(target=self._rival, args=(wanted,))
        if rival:
            rival.start()
        moves = self._submit("execution", "/v1/executions", wanted, "", accepted=_REFUSALS)
        if moves is not None:
            if self._rng.random() < _FOLLOWED:
                self._follow(moves[0])
            self._watch(moves[0], scene)
        if rival:
            rival.join()

    def scene(self) -> str:
        """Post a scene with an arm of its own, and return its id."""
        # Not idempotent: one that was made and not answered is no job.
        identifier: str = self.caller.ask("POST", "/v1/scenes", ARM).json()["id"]
        return identifier

    def _rival(self, wanted: dict[str, Any]) -> None:
        """Ask for the same motion at the same time, by another key, and wait for what comes."""
        with_own = Caller(self.caller.address, self._journal)
        rival = Client(
            f"{self._name}-rival-{self._num_asked}", with_own, self._journal, self._losses
        )
        try:
            moves = rival._submit("execution", "/v1/executions", wanted, "", accepted=_REFUSALS)
            if moves is not None:
                rival._await(moves[0])
        finally:
            with_own.close()

    def _submit(
        self,
        kind: str,
        path: str,
        body: dict[str, Any],
        wait: str,
        *,
        accepted: frozenset[int] = frozenset(),
    ) -> Any:
        """Ask for a job until it is accepted; None if it is refused for good."""
        self._num_asked += 1
        key = f"{self._name}-{self._num_asked}"
        answer = self.caller.ask("POST", path + wait, body, key=key, accepted=accepted)
        if not answer.is_success:
            return None
        job = answer.json()
        return self._journal.accept(Asked(kind, key, body, job["id"])), job

    def _cancel(self, asked: Asked) -> None:
        answer = self.caller.ask("POST", f"{_path(asked)}/cancel").json()
        asked.cancels.append(answer["unrecorded"])

    def _await(self, asked: Asked) -> dict[str, Any]:
        """Return a job that has ended."""
        began = asked_at = time.monotonic()
        starts = self.caller.address.starts
        while not asked.see(job := self.caller.get(_path(asked))):
            self._glimpse(asked, job)
            now = time.monotonic()
            if starts != self.caller.address.starts:
                began, starts = now, self.caller.address.starts
            if now - began > NEVER:
                what = f"is {job['state']} for {NEVER:g} s, unrecorded: {job['unrecorded']}"
                what += f"; {self.caller.gauges()}"
                self._journal.blame("every job ends", asked.id, what)
                break
            if asked.cancels and now - asked_at > _LATE:
                asked_at = now
                if "cancel" not in asked.cancels[-1]:
                    what = f"was canceled {_LATE:g} s ago and is {job['state']}"
                    self._journal.blame("a recorded cancel lasts", asked.id, what)
                self._cancel(asked)
            pause(_PERIOD)
        asked.num_losses = self._losses()
        return job

    def _follow(self, asked: Asked) -> None:
        """Follow the events of a job to its end, from one server to the next."""
        until = time.monotonic() + NEVER
        while time.monotonic() < until:
            after = asked.streamed[-1].number if asked.streamed else 0
            asked.streamed += self.caller.follow(f"{_path(asked)}/events", after)
            if asked.streamed and asked.streamed[-1].type == "finished":
                return
            pause(_PERIOD)

    def _glimpse(self, asked: Asked, job: dict[str, Any]) -> None:
        # Counted after the answer: what is lost before it was sent does not make it later.
        if (status := job.get("status")) is not None:
            asked.glimpses.append(Glimpse(self._losses(), status["time"]))

    def _watch(self, asked: Asked, scene: str) -> None:
        """Steer a motion, or do not; when it has ended, look where the robot stands."""
        if self._rng.random() < 0.5:
            pause(self._rng.uniform(0.0, 1.0))
            match self._rng.choice(["cancel", "pause", "speed"]):
                case "cancel":
                    self._cancel(asked)
                case "pause":
                    self._steer(asked, "pause")
                    pause(self._rng.uniform(0.0, 1.0))
                    self._steer(asked, "resume")
                case _:
                    self._steer(asked, "speed", {"speed": self._rng.choice(_SPEEDS)})
        ended = self._await(asked)
        found = self.caller.get(f"/v1/scenes/{scene}")
        newest = self.caller.get(f"/v1/executions?scene={scene}&limit=1")["items"][0]
        if ended["status"] is not None and newest["id"] == asked.id:
            asked.stood = (found["groups"][0]["positions"], ended["status"]["positions"])

    def _steer(self, asked: Asked, what: str, body: dict[str, Any] | None = None) -> None:
        self.caller.ask("POST", f"{_path(asked)}/{what}", body, accepted=_REFUSALS)


def _path(asked: Asked) -> str:
    return f"/v1/{asked.kind}s/{asked.id}"
