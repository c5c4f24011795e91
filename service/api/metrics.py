"""Metrics in Prometheus' text format (version 0.0.4)."""

from collections.abc import Mapping

_HELP = "# HELP wayproof_jobs Jobs by lane and state.\n# TYPE wayproof_jobs gauge\n"


def exposition(counts: Mapping[str, Mapping[str, int]]) -> str:
    """Return the metrics' text.

    Args:
        counts: Jobs by state, then by lane.
    """
    lines = [
        f'wayproof_jobs{{lane="{lane}",state="{state}"}} {count}\n'
        for state, by_lane in sorted(counts.items())
        for lane, count in sorted(by_lane.items())
    ]
    return _HELP + "".join(lines)
