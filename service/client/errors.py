"""ApiError: the server said no, and why."""

from wayproof_client.errors import ApiError
from wayproof_client.errors import checked as raise_for_problem

__all__ = ["ApiError", "raise_for_problem"]
