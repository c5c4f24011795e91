"""What schemathesis needs of us: a late import, a way to ask, and what every answer must be."""

import functools
import threading
import warnings

MOST_TRIES = 4


@functools.cache
def library():
    """Schemathesis, imported when the first test needs it: that takes a second."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import schemathesis
    return schemathesis


def checks():
    """No fault of the server, and status, content type and body as the document declares them."""
    not_a_server_error = library().checks.not_a_server_error
    from schemathesis.specs.openapi import checks as declared

    return [
        not_a_server_error,
        declared.status_code_conformance,
        declared.content_type_conformance,
        declared.response_schema_conformance,
    ]


def ask(client, case):
    """The answer to a case; asked again while a busy machine's database does not take it in time.

    So a client does, which the answer tells when (`Retry-After`).
    """
    for _ in range(MOST_TRIES):
        answer = asked(client, case)
        if answer.status_code != 503 or answer.json()["code"] != "database_unavailable":
            break
        threading.Event().wait(int(answer.headers["retry-after"]))
    return answer


def asked(client, case):
    sent = case.as_transport_kwargs(base_url="http://testserver")
    sent.pop("cookies", None)
    if isinstance(sent.get("data"), bytes | str):
        sent["content"] = sent.pop("data")
    return client.request(**sent)
