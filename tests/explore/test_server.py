"""The server: who may ask, what is sent, how it ends."""

import http.client
import json
import os
import re
import shutil
import signal
import socket
import stat
import threading
from importlib import resources
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pytest

from multilayer.errors import InputError
from multilayer.explore.explorer import Explorer
from multilayer.explore.server import POLICY, Server
from tests.cli.command import run
from tests.explore.command import exploring

FOAM = Path(__file__).parents[2] / "examples" / "foam_absorption.yaml"


@pytest.fixture(scope="module")
def server():
    """Give a server that runs."""
    with Server(Explorer(FOAM)) as one:
        threading.Thread(target=one.serve_forever, args=(0.05,), daemon=True).start()
        yield one
        one.shutdown()


def ask(server, method, path, body=None, *, token=True, **headers):
    """Send a request, and return status, headers and content."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, f"/{server.token}/{path}" if token else path, body, named)
    response = connection.getresponse()
    content = response.read()
    connection.close()
    return response.status, response.headers, content


def post(server, question, request, **headers):
    return ask(server, "POST", question, json.dumps(request), **{"Content_Type": "application/json", **headers})


@pytest.mark.parametrize(
    ("path", "kind"), [("", "text/html"), ("explore.js", "text/javascript"), ("explore.css", "text/css")]
)
def test_the_page_and_its_parts(path, kind, server):
    status, headers, content = ask(server, "GET", path)
    assert (status, headers.get_content_type()) == (200, kind)
    assert headers["Content-Security-Policy"] == POLICY
    assert headers["Referrer-Policy"] == "no-referrer"
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert len(content) > 1000


def test_the_page_needs_nothing_from_elsewhere(server):
    texts = [ask(server, "GET", path)[2].decode() for path in server.files]
    texts.append((resources.files("multilayer.explore") / "page/model.js").read_text())
    addresses = {address for text in texts for address in re.findall(r"https?://[^\s\"')]+", text)}
    assert addresses == {"http://www.w3.org/2000/svg"}  # a name, no address
    assert not any(
        re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(|Function\(", t) for t in texts
    )
    assert not re.search(r"<script>|<style| style=| on\w+=", texts[0])


def test_a_question_is_answered(server):
    status, headers, content = post(server, "start", {})
    answer = json.loads(content)
    assert (status, headers.get_content_type()) == (200, "application/json")
    assert answer["file"] == "foam_absorption.yaml"
    status, _, content = post(server, "evaluate", {"data": answer["data"]})
    assert (status, json.loads(content)["problems"]) == (200, [])


def test_one_connection_takes_many_questions(server):
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    for _ in range(3):
        headers = {"Content-Type": "application/json"}
        connection.request("POST", f"/{server.token}/watch", "{}", headers)
        assert len(json.loads(connection.getresponse().read())["digest"]) == 64
    connection.close()


class TestWhoMayAsk:
    @pytest.mark.parametrize("path", ["/", "/explore.js", "/wrong/", "/%e4/", "//", "/.."])
    def test_nobody_without_the_token(self, path, server):
        assert ask(server, "GET", path, token=False)[0] == 403
        assert ask(server, "POST", path, "{}", token=False, Content_Type="application/json")[0] == 403

    def test_no_token_that_is_nearly_right(self, server):
        for token in (server.token[:-1], server.token + "x", server.token.swapcase()):
            assert ask(server, "GET", f"/{token}/", token=False)[0] == 403

    @pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1:1", ""])
    def test_no_other_site_whose_name_leads_here(self, host, server):
        assert ask(server, "GET", "", Host=host)[0] == 403

    @pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1", "http://127.0.0.1:1"])
    def test_no_page_of_another_origin(self, origin, server):
        assert post(server, "watch", {}, Origin=origin)[0] == 403

    def test_the_page_itself(self, server):
        for name in ("127.0.0.1", "localhost"):
            host = f"{name}:{server.server_port}"
            assert post(server, "watch", {}, Origin=f"http://{host}", Host=host)[0] == 200

    @pytest.mark.parametrize("kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data"])
    def test_no_form(self, kind, server):
        assert post(server, "watch", {}, Content_Type=kind)[0] == 415

    def test_only_the_loopback_address_listens(self, server):
        assert server.server_address[0] == "127.0.0.1"

    def test_two_servers_have_two_tokens(self):
        with Server(Explorer(FOAM)) as one, Server(Explorer(FOAM)) as other:
            assert one.token != other.token
            assert len(one.token) >= 32


class TestBadRequests:
    @pytest.mark.parametrize("path", ["explore.py", "../explorer.py", "page/explore.js", "start", "%2e%2e/x"])
    def test_other_paths(self, path, server):
        assert ask(server, "GET", path)[0] == 404

    def test_other_questions(self, server):
        assert post(server, "answer", {})[0] == 404

    @pytest.mark.parametrize(
        "body", ["", "{", "[]", "3", '{"a": NaN}', "[" * 100_000, "\xff", '{"a": Infinity}', "null"]
    )
    def test_no_json(self, body, server):
        assert ask(server, "POST", "watch", body, Content_Type="application/json")[0] == 400

    def test_too_long(self, server):
        headers = {"Content_Type": "application/json", "Content_Length": "99999999999"}
        assert ask(server, "POST", "watch", "{}", **headers)[0] == 413
        headers["Content_Length"] = "-1"
        assert ask(server, "POST", "watch", "{}", **headers)[0] == 411

    @pytest.mark.parametrize("method", ["PUT", "DELETE", "OPTIONS", "HEAD", "TRACE", "PATCH"])
    def test_other_methods_and_nothing_for_other_sites(self, method, server):
        status, headers, _ = ask(server, method, "watch")
        assert status == 501
        assert not [name for name in headers if name.lower().startswith("access-control")]

    def test_an_address_that_is_too_long(self, server):
        assert ask(server, "GET", "x" * 70_000)[0] == 414

    @pytest.mark.parametrize("number", ["1e999", "-1e999", "1e300", "1e-300", "1" + 4000 * "0", "[[]]", "null"])
    @pytest.mark.parametrize("place", ['"layers": [{"type": "fluid", "thickness": %s}]', '"frequency": {"points": %s}'])
    def test_numbers_that_are_none_are_told(self, number, place, server):
        layers = '"layers": [{"type": "fluid", "thickness": 0.1}], "termination": "rigid", '
        body = f'{{"describe": true, "data": {{{layers}{place % number}}}}}'
        status, _, content = ask(server, "POST", "evaluate", body, Content_Type="application/json")
        (problem,) = json.loads(content, parse_constant=pytest.fail)["problems"]
        assert status == 200
        assert "bug" not in problem["text"]
        assert len(problem["text"]) < 1000

    def test_a_number_with_too_many_digits_is_no_json(self, server):
        body = f'{{"data": {"1" * 5000}}}'
        assert ask(server, "POST", "evaluate", body, Content_Type="application/json")[0] == 400

    def test_fields_that_there_are_none(self, server):
        data = json.loads(post(server, "start", {})[2])["data"]
        status, _, content = post(server, "evaluate", {"data": {**data, "\x1b[2J\ud800": 1}, "surprise": 1})
        (problem,) = json.loads(content)["problems"]
        assert status == 200
        assert "\x1b" not in problem["text"]

    def test_a_body_that_never_comes_holds_nobody_up(self, server, monkeypatch):
        monkeypatch.setattr("multilayer.explore.server._Handler.timeout", 0.3)
        with socket.create_connection(("127.0.0.1", server.server_port), timeout=20) as silent:
            head = f"POST /{server.token}/watch HTTP/1.1\r\nHost: 127.0.0.1:{server.server_port}\r\n"
            silent.sendall(f"{head}Content-Type: application/json\r\nContent-Length: 100\r\n\r\n{{".encode())
            assert post(server, "watch", {})[0] == 200
            assert silent.recv(1000) == b""  # given up

    def test_windows_that_ask_at_once_get_their_own_answers(self, server):
        data = json.loads(post(server, "start", {})[2])["data"]
        layers = [{**data["layers"][0], "thickness": f"{n} m"} for n in (0.05, 50, 0.1, 70)]
        answers = {}

        def asked(i):
            answers[i] = json.loads(post(server, "evaluate", {"data": {**data, "layers": [layers[i]]}})[2])

        threads = [threading.Thread(target=asked, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(20)
        meant = {i: [text for text in answer["warnings"] if "is '" in text] for i, answer in answers.items()}
        assert [len(meant[i]) for i in range(4)] == [0, 1, 0, 1]
        assert "50 mm" in meant[1][0]
        assert "70 mm" in meant[3][0]

    def test_a_bug_is_told_on_the_page(self, server, monkeypatch):
        def fail(request):
            raise RuntimeError("the roof fell in")

        monkeypatch.setitem(server.explorer.answers, "watch", fail)
        status, _, content = post(server, "watch", {})
        assert status == 200
        assert "a bug" in json.loads(content)["problems"][0]["text"]


class TestCommand:
    def test_a_port_in_use_is_told(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = taken.getsockname()[1]
            done = run("explore", FOAM, "--port", port, "--no-browser")
        assert done.status == 2
        assert f"--port: {port} of 127.0.0.1 cannot be had" in done.err
        assert "leave --port out" in done.err

    @pytest.mark.parametrize("port", [-1, 65536])
    def test_a_port_that_is_none(self, port):
        done = run("explore", FOAM, f"--port={port}", "--no-browser")
        assert (done.status, done.err) == (2, f"--port: {port} is not allowed; ports go from 1 to 65535\n")

    def test_a_file_with_mistakes(self, tmp_path):
        file = tmp_path / "bad.yaml"
        file.write_text("version: 1\nlayers: [{type: fluid, thicknes: 1}]\n")
        done = run("explore", file, "--no-browser")
        assert done.status == 2
        assert "did you mean 'thickness'?" in done.err
        assert "http" not in done.out

    def test_a_measured_file_that_is_missing(self):
        done = run("explore", FOAM, "--measured", "nothing.csv", "--no-browser")
        assert done.status == 2
        assert "nothing.csv" in done.err

    @pytest.mark.skipif(os.name == "nt", reason="Windows has no such signal")
    @pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
    def test_ends_when_asked(self, number, tmp_path):
        file = Path(shutil.copy(FOAM, tmp_path))
        with exploring(file) as (process, url):
            port, token = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/([\w-]+)/", url).groups()
            connection = http.client.HTTPConnection("127.0.0.1", int(port), timeout=20)
            connection.request("GET", f"/{token}/")
            response = connection.getresponse()
            response.read()
            assert response.status == 200  # and the connection stays open
            process.send_signal(number)
            out, err = process.communicate(timeout=10)
            connection.close()
        assert (process.returncode, out) == (0, "")
        assert err.splitlines()[-1] == "ended"
        assert "Traceback" not in err
        assert [path.name for path in tmp_path.iterdir()] == [file.name]


def test_no_process_is_told_the_token(monkeypatch):
    """For every user may read what a process was called with."""
    told = []

    def look(address):
        file = Path(url2pathname(urlsplit(address).path))
        told.append((address, file, file.read_text(), stat.S_IMODE(file.stat().st_mode)))

    monkeypatch.setattr("webbrowser.open", look)
    monkeypatch.setattr("multilayer.explore.server.Server.serve_forever", lambda *_, **__: None)
    done = run("explore", FOAM, DISPLAY=":0")
    ((address, file, text, mode),) = told
    url = done.out.strip()
    assert url.rstrip("/").rsplit("/", 1)[-1] not in address
    assert f"url={url}" in text
    assert os.name == "nt" or mode == 0o600
    assert not file.exists()


def test_a_port_may_be_chosen():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with Server(Explorer(FOAM), port) as server:
        assert server.url.startswith(f"http://127.0.0.1:{port}/")


def test_a_port_below_1024_is_no_traceback(monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("multilayer.explore.server.Server.server_bind", refuse)
    with pytest.raises(InputError, match=r"--port: 80 of 127\.0\.0\.1 cannot be had \(Permission denied\)"):
        Server(Explorer(FOAM), 80)
