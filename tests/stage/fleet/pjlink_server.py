"""A projector that speaks PJLink class 1, written from its specification alone (1.04, 2013).

Its digest is that of the specification's own example: password JBMIAProjectorLink, number 498e4a67.
"""

import socket
import threading

PASSWORD, NUMBER, DIGEST = "JBMIAProjectorLink", "498e4a67", "5d8409bc1c3fa39749434aa3a5c38682"


class ProjectorServer:
    """Answers commands as a table says; `garbage` replaces every answer from the greeting on."""

    def __init__(self, guarded=False):
        self.guarded, self.garbage, self.silent = guarded, None, False
        self.answers = {"POWR ?": "0", "LAMP ?": "1234 0 567 0", "ERST ?": "000000",
                        "POWR 1": "OK", "POWR 0": "OK"}  # fmt: skip
        self.asked = []  # commands that were accepted
        self.closed = False
        self._open()

    def _open(self, port=0):
        self._listener = socket.create_server(("127.0.0.1", port))
        self.port = self._listener.getsockname()[1]
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            with client:
                client.settimeout(10.0)
                try:
                    self._talk(client)
                except OSError:
                    continue

    def _talk(self, client):
        if self.silent:
            client.recv(1000)
            return
        if self.garbage is not None:
            client.sendall(self.garbage)
            client.recv(1000)
            return
        client.sendall(f"PJLINK 1 {NUMBER}\r".encode() if self.guarded else b"PJLINK 0\r")
        held, known = b"", not self.guarded
        while data := client.recv(1000):
            held += data
            while b"\r" in held:
                line, _, held = held.partition(b"\r")
                text = line.decode("ascii")
                if not known:
                    if not text.startswith(DIGEST):
                        client.sendall(b"PJLINK ERRA\r")
                        return
                    known, text = True, text.removeprefix(DIGEST)
                assert text.startswith("%1"), text
                command = text[2:]
                self.asked.append(command)
                if self.answers.get(command) == "OK":
                    # Class 1: 2 is cooling down, 3 warming up.
                    self.answers["POWR ?"] = "3" if command.endswith("1") else "2"
                client.sendall(f"%1{command[:4]}={self.answers.get(command, 'ERR1')}\r".encode())

    def close(self):
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._thread.join(10.0)

    def reopen(self):
        """Come back at the same port."""
        self._open(self.port)
