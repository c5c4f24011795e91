"""A typed client of Wayproof's HTTP API: `Client` to call, `AsyncClient` to await.

`wayproof_client.models` has what is answered, `wayproof_client.requests` what is asked.
"""

from wayproof_client import models, requests
from wayproof_client.async_client import AsyncClient
from wayproof_client.client import Client
from wayproof_client.errors import ApiError, ClientError, JobFailed, NotModified, WaitTimeout
from wayproof_client.plan_view import PlanView

__all__ = [
    "ApiError",
    "AsyncClient",
    "Client",
    "ClientError",
    "JobFailed",
    "NotModified",
    "PlanView",
    "WaitTimeout",
    "models",
    "requests",
]
