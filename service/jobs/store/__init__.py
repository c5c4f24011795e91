"""How jobs are kept: what changes them, and what is asked of them. Tables are in `sql`."""
