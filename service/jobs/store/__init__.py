"""How jobs are kept: tables, migrations, and the changes and queries of them."""
