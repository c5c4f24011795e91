"""Revisions of the database, in Alembic's order; `service.jobs.store.sql.schema` applies them."""
