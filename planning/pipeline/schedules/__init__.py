"""Schedules: when several motions begin, so that their robots keep their margins of each other.

Two motions meet, or do not, by the difference of their beginnings alone (`coordination_diagram`);
the smallest delays are those of a network of such differences (`delay_network`).
"""
