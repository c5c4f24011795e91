"""Tests that need the extra `rerun`, which only `make rerun` installs."""

import os

# Half a gigabyte, which no other test needs: without it nothing here is collected.
collect_ignore_glob = [] if "WAYPROOF_TEST_RERUN" in os.environ else ["test_*.py"]
