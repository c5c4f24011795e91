"""All kinds of attacks, by name."""

from tests.adversary import cars, checks, clearance, constraints, degrees, floats, jumps, plans, rates, torques, winding

KINDS = {
    "clearance": clearance,
    "rates": rates,
    "jumps": jumps,
    "floats": floats,
    "degrees": degrees,
    "cars": cars,
    "plans": plans,
    "checks": checks,
    "torques": torques,
    "winding": winding,
    "constraints": constraints,
}
