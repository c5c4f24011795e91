"""Motions that are carried out: those that are asked for, and those that are followed."""
