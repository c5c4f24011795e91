"""Jobs under faults: what is asked, what goes wrong meanwhile, and what must hold all the same."""
