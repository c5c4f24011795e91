"""Revisions of the database, in Alembic's order; `service.jobs.schema` applies them."""
