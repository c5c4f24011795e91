"""All kinds of attacks, by name."""

from tests.adversary import cars, clearance, constraints, degrees, floats, jumps, rates, winding

KINDS = {
    "clearance": clearance,
    "rates": rates,
    "jumps": jumps,
    "floats": floats,
    "degrees": degrees,
    "cars": cars,
    "winding": winding,
    "constraints": constraints,
}
