"""Runs a ParaView client with a server of its own, whose port is the client's last argument.

serve.py <client command>... -- <server command>...
"""

import socket
import subprocess
import sys


def serve(client, server):
    with socket.socket() as free:
        free.bind(("localhost", 0))
        port = str(free.getsockname()[1])
    # It ends when the client does.
    with subprocess.Popen(server + ["--server-port=" + port], text=True, stdout=subprocess.PIPE) as process:
        try:
            for line in process.stdout:
                if "Accepting connection" in line:
                    break
            subprocess.run(client + [port], check=True)
        except BaseException:
            process.kill()
            raise


separator = sys.argv.index("--")
serve(sys.argv[1:separator], sys.argv[separator + 1:])
