"""Hostile clients: bytes as they are sent, each with the statuses that are right.

Read by test_clients.py; a connection may also be closed without an answer.
"""

import gzip

HOST = b"Host: localhost\r\n"
CLOSE = b"Connection: close\r\n"
JSON = b"Content-Type: application/json\r\n"
BOMB = gzip.compress(b" " * 10_000_000)


def get(path=b"/v1/plans", headers=b"", version=b"1.1", host=HOST):
    return b"GET " + path + b" HTTP/" + version + b"\r\n" + host + CLOSE + headers + b"\r\n"


def post(headers, body=b"{}", path=b"/v1/plans"):
    return b"POST " + path + b" HTTP/1.1\r\n" + HOST + CLOSE + JSON + headers + b"\r\n" + body


def length(number):
    return b"Content-Length: " + str(number).encode() + b"\r\n"


CHUNKED = b"Transfer-Encoding: chunked\r\n"
CLIENTS = {
    "greeting of TLS": (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 500, {400}),
    "greeting of SSH": (b"SSH-2.0-OpenSSH_9.7\r\n", {400}),
    "preface of HTTP/2": (b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", {400}),
    "HTTP/0.9": (b"GET /\r\n\r\n", {400}),
    "HTTP/9.9": (get(version=b"9.9"), {400}),
    "noise": (bytes(range(256)) * 10, {400}),
    "no host": (get(host=b""), {400}),
    "two hosts": (get(host=HOST + b"Host: evil.example\r\n"), {400}),
    "another host": (get(host=b"Host: evil.example\r\n"), {400}),
    # it is for the proxies of others; the header says which host is meant
    "address of another host": (get(b"http://evil.example/v1/plans"), {200}),
    "tunnel": (b"CONNECT evil.example:443 HTTP/1.1\r\n" + HOST + CLOSE + b"\r\n", {400, 404, 405}),
    "method of nonsense": (b"FETCH /v1/plans HTTP/1.1\r\n" + HOST + CLOSE + b"\r\n", {400, 405}),
    "trace": (b"TRACE /v1/plans HTTP/1.1\r\n" + HOST + CLOSE + b"\r\n", {400, 405}),
    "WebSocket": (
        get(headers=b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"),
        {200, 400, 403, 404, 426},
    ),
    "header of a NUL": (get(headers=b"X-A: a\0b\r\n"), {400}),
    "header without a colon": (get(headers=b"nonsense\r\n"), {400}),
    "header over two lines": (get(headers=b"X-A: a\r\n b\r\n"), {200, 400}),
    "header of a megabyte": (get(headers=b"X-A: " + b"a" * 2**20 + b"\r\n"), {431}),
    "hundred thousand headers": (
        get(headers=b"".join(b"X-%d: a\r\n" % i for i in range(100_000))), {431}
    ),
    "path of a megabyte": (get(b"/v1/plans/" + b"a" * 2**20), {400, 404, 414, 431}),
    "path of a NUL": (get(b"/v1/plans/\0"), {400}),
    "path above the root": (get(b"/../../etc/passwd"), {400, 404}),
    "path above the documentation": (get(b"/docs/..%2f..%2fetc%2fpasswd"), {404, 422}),
    "query of a megabyte": (get(b"/v1/plans?a=" + b"a" * 2**20), {400, 414, 422, 431}),
    "two lengths": (post(length(2) + length(3)), {400}),
    "length and chunks": (post(length(2) + CHUNKED, b"0\r\n\r\n"), {400}),
    "chunks that are no chunks": (post(CHUNKED, b"zz\r\n{}\r\n0\r\n\r\n"), {400}),
    "chunk beyond all numbers": (post(CHUNKED, b"F" * 20 + b"\r\n"), {400}),
    "chunks of an unknown kind": (post(b"Transfer-Encoding: gzip\r\n"), {400}),
    "length below zero": (post(length(-1)), {400}),
    "length beyond all numbers": (post(length(10**30)), {400}),
    "length of a terabyte": (post(length(10**12)), {413}),
    "body that is zipped": (
        post(b"Content-Encoding: gzip\r\n" + length(len(BOMB)), BOMB), {400, 415}
    ),
    "expectation of nonsense": (post(b"Expect: the-unexpected\r\n" + length(2)), {200, 417, 422}),
    "another request inside": (
        post(length(0), get(b"/v1/scenes", b"X-A: smuggled\r\n")), {400, 422}
    ),
    "event of nonsense": (
        get(b"/v1/plans/pln_0/events", b"Last-Event-ID: \xff\xfe\r\n"), {404, 422}
    ),
}  # fmt: skip
