"""Regions to the wire, and from it."""

from typing import Any

from planning import RegionOptions, Regions
from service.regions.models import RegionsRequest


def region_options_value(request: RegionsRequest) -> RegionOptions:
    """Return the domain's options."""
    return RegionOptions(
        num_regions=request.num_regions,
        coverage=request.coverage,
        along=request.along,
        num_free=request.num_free,
        iterations=request.iterations,
        bounds={name: (low, high) for name, (low, high) in request.bounds.items()},
        margin=request.margin,
        padding=request.padding,
    )


def regions_wire(regions: Regions) -> dict[str, Any]:
    """Return regions for the wire; `regions_value` reads them again, bit for bit."""
    counts = {"num_regions": len(regions.regions), "num_portals": len(regions.portals)}
    return {**regions.as_json, **counts, "digest": regions.digest}


def regions_value(wire: dict[str, Any]) -> Regions:
    """Return the domain's regions."""
    derived = ("num_regions", "num_portals", "digest")
    return Regions.from_json({name: wire[name] for name in wire if name not in derived})
