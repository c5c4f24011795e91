"""ProofPanel: what is proven of a motion: a row per check, each leads to its place and time."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import viser

from service.studio import texts
from service.studio.motions.checks import words_of


class ProofPanel:
    """The checks of a certificate."""

    def __init__(
        self,
        gui: viser.GuiApi,
        checks: Sequence[Mapping[str, Any]],
        on_choose: Callable[[Mapping[str, Any]], None],
    ) -> None:
        """Show the checks, folded.

        Args:
            gui: Where it is shown, in the container that is open.
            checks: As the API has them.
            on_choose: Called with the check that was clicked.
        """
        failed = sum(not check["passed"] for check in checks)
        told = f"{failed} of {len(checks)} checks failed" if failed else f"{len(checks)} checks"
        with gui.add_folder(told, expand_by_default=bool(failed)):
            for check in sorted(checks, key=lambda check: (check["passed"], _rank(check))):
                self._add(gui, check, on_choose)
            self._told = gui.add_html(texts.told("Click one: the motion goes there."))

    def _add(
        self,
        gui: viser.GuiApi,
        check: Mapping[str, Any],
        on_choose: Callable[[Mapping[str, Any]], None],
    ) -> None:
        words = words_of(check)
        row = gui.add_button_group(words.name, (words.value,), hint=words.hint)

        @row.on_click
        def _(_: Any) -> None:
            self._told.content = texts.told(
                f"{words.name}: {words.hint}", "plain" if check["passed"] else "bad"
            )
            on_choose(check)


def _rank(check: Mapping[str, Any]) -> int:
    """Order checks by what they are worth to a reader: clearance, limits, then the rest."""
    name = check["name"]
    if name == "clearance":
        return 0
    return 1 if words_of(check).curve else 2
