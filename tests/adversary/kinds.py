"""All kinds of attacks, by name."""

from tests.adversary import (
    cars,
    checks,
    clearance,
    constraints,
    degrees,
    floats,
    formats,
    identities,
    jumps,
    neighbours,
    plans,
    rates,
    samples,
    torques,
    winding,
    wire,
)

KINDS = {
    "clearance": clearance,
    "rates": rates,
    "samples": samples,
    "jumps": jumps,
    "neighbours": neighbours,
    "floats": floats,
    "degrees": degrees,
    "cars": cars,
    "wire": wire,
    "formats": formats,
    "identities": identities,
    "plans": plans,
    "checks": checks,
    "torques": torques,
    "winding": winding,
    "constraints": constraints,
}
