"""Events of a job, from a stream of server-sent events."""

from wayproof_client.events import Event, decode_events

__all__ = ["Event", "decode_events"]
