"""The code in the guide runs."""

import re

import pytest

import service.executions.worker  # noqa: F401  (before the clock is replaced, which it keeps)
from tests.clocks import FakeClock
from tests.conventions.guide import PAGES

BLOCKS = [
    pytest.param(block, id=f"{page.stem}-{i}")
    for page in PAGES
    for i, block in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL))
]


@pytest.mark.parametrize("block", BLOCKS)
def test_python_blocks_run(
    block: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What they show has a deadline, which a busy machine must not miss."""
    monkeypatch.setattr("time.monotonic", FakeClock())
    exec(compile(block, "guide", "exec"), {"__name__": "guide"})
    capsys.readouterr()
