"""Delivered samples in the formats of other programs; `formats` names them."""
