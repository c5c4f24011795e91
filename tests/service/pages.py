"""Lists of the API, page after page."""


def walk(client, path, limit):
    """Everything that a list has, whatever other tests have made so far."""
    seen, cursor = [], ""
    asked = f"{path}{'&' if '?' in path else '?'}limit={limit}"
    while cursor is not None:
        page = client.get(f"{asked}{cursor and '&cursor=' + cursor}").json()
        assert len(page["items"]) <= limit
        seen += page["items"]
        cursor = page["next"]
    return seen
