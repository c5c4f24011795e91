"""All kinds of attacks, by name."""

from tests.adversary import cars, clearance, degrees, floats, jumps, rates

KINDS = {
    "clearance": clearance,
    "rates": rates,
    "jumps": jumps,
    "floats": floats,
    "degrees": degrees,
    "cars": cars,
}
