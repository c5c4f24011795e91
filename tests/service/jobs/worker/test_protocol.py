"""Frames arrive whole, whatever the pieces they come in."""

import socket
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs.worker.protocol import (
    HEADER_SIZE,
    MAX_BODY,
    Message,
    MessageKind,
    MessagePipe,
    two_parts,
    unpack_header,
)

FRAMES = st.builds(
    Message, st.sampled_from(MessageKind), st.integers(0, 2**40), st.binary(max_size=300)
)


@given(st.lists(FRAMES, max_size=5), st.integers(1, 50))
def test_frames_arrive_as_they_were_sent(messages, piece):
    ours, theirs = socket.socketpair()
    with ours, theirs:
        stream = b"".join(message.packed() for message in messages)
        link = MessagePipe(theirs)

        def send():
            for begin in range(0, len(stream), piece):
                ours.sendall(stream[begin : begin + piece])
            ours.shutdown(socket.SHUT_WR)

        thread = threading.Thread(target=send)
        thread.start()
        received = [link.receive() for _ in messages]
        thread.join()
        assert received == messages
        assert link.has_message  # the end is news too
        assert link.receive() is None


@given(st.text(), st.text())
def test_two_parts_come_apart_again(first, rest):
    first = first.encode("utf-8", "replace").decode()
    rest = rest.encode("utf-8", "replace").decode()
    parts = Message(MessageKind.TASK, 1, two_parts(first, rest)).parts
    assert parts == (first.replace("\n", " "), rest)


def test_noise_is_no_header():
    for noise in (b"\xff" * HEADER_SIZE, b"\0\0\0\1\x63" + b"\0" * 8):
        with pytest.raises(ValueError, match=r"message|MessageKind"):
            unpack_header(noise)
    header = Message(MessageKind.EVENT, 3, b"abc").packed()[:HEADER_SIZE]
    assert unpack_header(header) == (3, MessageKind.EVENT, 3)
    assert MAX_BODY < 2**32
