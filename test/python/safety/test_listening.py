"""Sockets that other machines can reach are found, and those of loopback are not."""

from __future__ import annotations

import os
import socket

import psutil
import pytest

from yarm.safety.listening import Listener, exposure, listeners


@pytest.fixture
def listening():
    """Opens sockets of this process that listen."""
    opened = []

    def listen(address, family=socket.AF_INET):
        opened.append(socket.socket(family, socket.SOCK_STREAM))
        opened[-1].bind((address, 0))
        opened[-1].listen(1)
        return opened[-1].getsockname()[1]

    yield listen
    for each in opened:
        each.close()


def test_a_socket_on_every_interface_is_named_with_its_port(listening):
    port = listening("0.0.0.0")
    assert f"0.0.0.0:{port}" in exposure()


def test_a_socket_on_loopback_is_known_and_nobodys_business(listening):
    port = listening("127.0.0.1")
    assert Listener("127.0.0.1", port) in listeners(os.getpid())
    assert str(port) not in exposure()


def test_only_sockets_that_listen_count(listening):
    port = listening("0.0.0.0")
    caller = socket.create_connection(("127.0.0.1", port))
    own = caller.getsockname()[1]
    assert own not in [listener.port for listener in listeners()]
    caller.close()


@pytest.mark.parametrize(
    "address, loopback",
    [
        ("127.0.0.1", True),
        ("127.8.9.1", True),
        ("::1", True),
        ("::ffff:127.0.0.1", True),
        ("0.0.0.0", False),
        ("::", False),
        ("192.168.1.5", False),
        ("fe80::1%eth0", False),
        ("::ffff:10.0.0.1", False),
    ],
)
def test_which_addresses_are_of_this_machine(address, loopback):
    assert Listener(address, 1).loopback is loopback


def test_an_address_with_colons_is_bracketed():
    assert str(Listener("::", 11311)) == "[::]:11311"


def test_a_process_that_is_gone_is_an_error():
    with pytest.raises(psutil.NoSuchProcess):
        exposure(2**22 + 1)
