"""What the page of live states shows runs: pick and place without any bookkeeping."""

import re
from pathlib import Path

from tests.profiles import only_campaign

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "live-state.md"


@only_campaign("a pick and a place: 10 s")
def test_the_loop_of_the_page_runs():
    """With the clock of the machine, without which no robot moves."""
    [block] = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    found = {"__name__": "guide"}
    exec(compile(block, "guide", "exec"), found)
    assert found["state"]["attached"] == []
    (arm,) = found["state"]["robots"]
    assert arm["status"] == "at_rest"
