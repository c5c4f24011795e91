"""Motions of the client: timed, certified, stopped and spliced."""
