import socket
import threading
from contextlib import closing

import pytest
import zmq

from subsea.base.errors import UserError
from subsea.stage.cluster import link
from subsea.stage.cluster.follower import NO_KEYS, Follower
from subsea.stage.cluster.master import Master


def test_a_node_says_that_connections_end_as_they_begin(seas):
    """A master with keys hangs up on a node without them, mostly before it says why."""
    with closing(socket.create_server(("127.0.0.1", 0))) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"

        def hang_up():
            for _ in range(5):
                server.accept()[0].close()

        threading.Thread(target=hang_up, daemon=True).start()
        words = []
        with closing(Follower(seas[0], "left", "master", address, tell=words.append)) as node:
            assert node.waiting == f"waiting for the master at {address}"
            for _ in range(300):
                node.picture(0.1)
                if node.waiting.endswith(NO_KEYS):
                    break
            assert words[1:] == [f"at {address} each connection ends as it begins: {NO_KEYS}"]


def test_no_socket_is_left_where_none_can_listen(seas, address):
    with closing(Master(seas[0], ["left"], address)):
        context = zmq.Context()
        with pytest.raises(UserError, match="cannot listen there"):
            link.listening(context, address, None, 1000)
        context.term()  # would wait for an open socket
