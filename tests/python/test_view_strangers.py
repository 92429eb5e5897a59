"""Who is kept out of `rrf view`, and that a page that leaves leaves no work behind."""

import os
import pathlib
import re
import socket
import time
import urllib.error
import urllib.request

import pytest
from viewer import Viewer


def get(url, **headers):
    """Status and headers of a plain GET."""
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers)) as answer:
            return answer.status, dict(answer.headers), answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, dict(error.headers), ""


def test_strangers_stay_out(server):
    host = re.match(r"http://([^/]+)/", server)[1]
    port = int(host.rsplit(":", 1)[1])
    status, headers, page = get(server)
    assert status == 200
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy and "unsafe" not in policy and "*" not in policy
    assert "http" not in re.sub(r"http://www.w3.org/2000/svg", "", page)
    assert get(f"http://{host}/")[0] == 403
    assert get(f"http://{host}/?token=0")[0] == 403
    assert get(server[:-1])[0] == 403
    assert get(server, Host=f"rebound.example:{port}")[0] == 403
    assert get(server, Origin="http://rebound.example")[0] == 403
    assert get(server.replace("/?", "/nothing?"))[0] == 404
    # only on the loopback address
    for address in {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None)}:
        if not address.startswith(("127.", "::1")):
            with pytest.raises(OSError):
                socket.create_connection((address, port), timeout=2)


def test_wrong_token_in_the_browser(browser, server):
    page = browser.new_page()
    assert page.goto(server[:-2] + "zz").status == 403
    page.close()


def test_closing_the_page_frees_the_work(browser, server):
    """While a page traces, the server is busy; once it is closed, it is not."""
    viewer = Viewer(browser, server)
    viewer.page.click("#trace")
    viewer.wait_paths(2)
    port = int(re.search(r":(\d+)/", server)[1])
    process = owner(port)
    viewer.page.close()
    # a pass that is on its way may take long on a busy machine
    end = time.monotonic() + 60
    while (busy := busy_seconds(process, 1.0)) >= 0.05:
        assert time.monotonic() < end, busy


def owner(port):
    """The process that listens on a port, by /proc."""
    line = next(
        line
        for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]
        if line.split()[1].endswith(f":{port:04X}") and line.split()[3] == "0A"
    )
    wanted = f"socket:[{line.split()[9]}]"
    for folder in pathlib.Path("/proc").glob("[0-9]*/fd"):
        try:
            if any(os.readlink(fd) == wanted for fd in folder.iterdir()):
                return folder.parent
        except OSError:
            continue
    raise LookupError(port)


def busy_seconds(process, seconds):
    """Processor time that it uses in the next `seconds`."""
    def used():
        fields = (process / "stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    before = used()
    time.sleep(seconds)
    return used() - before
