"""Paths made shorter and safer once there is one."""
