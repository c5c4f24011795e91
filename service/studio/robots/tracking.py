"""unit_of(): in what the tracking error of a group is told."""

from service.studio.api import ShownGroup

_UNITS = {"prismatic": "mm", "revolute": "mrad", "continuous": "mrad"}


def unit_of(group: ShownGroup) -> str:
    """Return the unit of a thousandth of an error: of a group that has both kinds, both."""
    units = {_UNITS.get(str(joint["type"]), "mrad or mm") for joint in group.joints}
    return units.pop() if len(units) == 1 else "mrad or mm"
