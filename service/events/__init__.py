"""Streams of numbered events: replayed from their record and followed live."""
