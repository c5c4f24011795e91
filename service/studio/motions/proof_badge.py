"""ProofBadge: what is proven of a motion in the scene as it is now; it can be proven again."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import viser

from service.studio import texts
from service.studio.cell import Cell
from service.studio.motions.verdict import Proof, verdict_of
from service.studio.newest import Newest


class ProofBadge:
    """The line that says whether a motion is proven, and in which revision of the scene."""

    def __init__(
        self,
        gui: viser.GuiApi,
        cell: Cell,
        job: Mapping[str, Any],
        on_verdict: Callable[[], None],
        on_fault: Callable[[Exception], None],
    ) -> None:
        """Show the certificate of a plan.

        Args:
            gui: Where it is shown, in the container that is open.
            cell: The scene.
            job: The plan, with its request and its result.
            on_verdict: Called once the motion was proven, or refuted, in a newer revision.
            on_fault: Is told what goes wrong.
        """
        self._cell, self._job = cell, job
        self._on_verdict = on_verdict
        self._newest = Newest(on_fault)
        margin = job["request"]["margin"]
        kept = cell.scene.document.get("margin") if margin is None else margin
        self._proof = Proof(
            certificate=job["result"]["certificate"],
            duration=float(job["result"]["trajectory"]["duration"]),
            revision=int(job["request"]["revision"]),
            has_margin=bool(kept),
        )
        self._told = gui.add_html(texts.told("…"))
        self._again = gui.add_button(
            "Prove it again",
            icon=viser.Icon.SHIELD_CHECK,
            color=texts.SOFT,
            visible=False,
            hint="Holds the motion against the scene as it is now",
        )
        self._again.on_click(lambda _: self._newest.ask(self._prove_again))
        self.look_again()

    @property
    def is_refuted(self) -> bool:
        """Whether the motion is known not to hold in the newest revision."""
        is_newest = self._proof.revision == self._cell.scene.revision
        return is_newest and not self._proof.certificate["proven"]

    @property
    def is_stale(self) -> bool:
        """Whether nothing is known of the newest revision."""
        return self._proof.revision != self._cell.scene.revision

    def look_again(self) -> None:
        """Say what is known, once the scene is another one."""
        self._again.visible = self.is_stale
        self._told.content = verdict_of(self._proof, self._cell.scene.revision)

    def refute(self, evidence: Mapping[str, Any]) -> None:
        """Take note that the server refused to carry the motion out.

        Args:
            evidence: Of the refusal: its checks failed in the newest revision.
        """
        certificate = {
            "proven": False,
            "checks": [{**check, "passed": False} for check in evidence.get("checks") or ()],
            "pair": evidence.get("pair") or [],
            "observed_clearance": evidence.get("value"),
            "time": evidence.get("time"),
        }
        self._note(certificate, self._cell.scene.revision)

    def close(self) -> None:
        """Prove nothing any more."""
        self._newest.close()

    def _prove_again(self) -> None:
        revision = self._cell.scene.revision
        self._told.content = texts.told(f"proving it in revision {revision}", "busy")
        self._again.visible = False
        try:
            certificate = self._cell.api.certify_again(self._job, revision)
        except Exception:
            self.look_again()
            raise
        self._note(certificate, revision)

    def _note(self, certificate: Mapping[str, Any], revision: int) -> None:
        self._proof = replace(self._proof, certificate=certificate, revision=revision)
        self._on_verdict()
        self.look_again()
