"""Revisions of the database, in Alembic's order; `service.jobs.store.schema` applies them."""
