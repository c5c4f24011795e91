"""What Alembic runs for every command: the revisions, in the caller's connection."""

from alembic import context


def run() -> None:
    """Run them."""
    context.configure(connection=context.config.attributes["connection"], transactional_ddl=True)
    with context.begin_transaction():
        context.run_migrations()


if __name__ == "env_py":  # by that name Alembic runs this file; an import of it runs nothing
    run()
