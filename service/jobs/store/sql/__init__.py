"""The databases themselves: tables, migrations, connections. It knows no job."""
