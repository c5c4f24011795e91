"""All kinds of attacks, by name."""

from tests.adversary import clearance

KINDS = {"clearance": clearance}
