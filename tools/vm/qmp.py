"""QEMU's control socket (QEMU Machine Protocol)."""
import json
import socket
import time


class Qmp:
    def __init__(self, path, is_alive):
        deadline = time.monotonic() + 10
        while True:
            self.socket = socket.socket(socket.AF_UNIX)
            try:
                self.socket.connect(path)
                break
            except OSError:
                self.socket.close()
                if not is_alive() or time.monotonic() > deadline:
                    raise RuntimeError("QEMU's control socket does not answer") from None
                time.sleep(0.01)
        self.socket.settimeout(30)
        self.lines = self.socket.makefile("rb")
        self.lines.readline()
        self.events = []
        self("qmp_capabilities")

    def _next(self):
        line = self.lines.readline()
        if not line:
            raise RuntimeError("QEMU ended")
        return json.loads(line)

    def __call__(self, command, **arguments):
        """The answer to a command; an underscore in an argument's name stands for a hyphen."""
        arguments = {name.replace("_", "-"): value for name, value in arguments.items()}
        self.socket.sendall(json.dumps({"execute": command, "arguments": arguments}).encode() + b"\n")
        while True:
            answer = self._next()
            if "error" in answer:
                raise RuntimeError("%s: %s" % (command, answer["error"]["desc"]))
            if "return" in answer:
                return answer["return"]
            self.events.append(answer)

    def wait_for(self, event, device):
        """Returns when `event` has come to the device of that name."""
        while not any(seen["event"] == event and seen["data"].get("device") == device for seen in self.events):
            self.events.append(self._next())
        self.events.clear()
