"""Path constraints: from JSON to the domain."""

from service.plans.models.constraints import constraints_to_domain as constraint_values

__all__ = ["constraint_values"]
