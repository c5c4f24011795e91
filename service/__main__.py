"""Entry point of `wayproof` and `python -m service`.

Workers import this module again (multiprocessing's forkserver does), so it imports nothing.
"""


def main() -> None:
    """Run the command line."""
    from service.cli.app import app  # noqa: PLC0415  (kept out of workers)

    app()


if __name__ == "__main__":
    main()
