"""Tests that need generators of clients, which only `make clients` installs."""

import os

# Where they are; without it nothing here is collected, so `make test` needs no network and no node.
collect_ignore_glob = [] if "WAYPROOF_GENERATORS" in os.environ else ["test_*.py"]
