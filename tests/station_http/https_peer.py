"""Somebody else's HTTP client (Python's http.client and ssl) against the server: judge of HTTP/1.1 and TLS.

usage: https_peer.py PORT AUTHORITY.pem      exit 0: all holds; else the first line that does not, on stderr
The server's handler answers "METHOD PATH BODY" as text/plain.
"""
import http.client
import socket
import ssl
import sys
import warnings

port = int(sys.argv[1])
authority = sys.argv[2]


def context():
    made = ssl.create_default_context(cafile=authority)
    made.check_hostname = True
    return made


def expect(seen, wanted, what):
    if seen != wanted:
        sys.exit(f"{what}: {seen!r} instead of {wanted!r}")


def ask(connection, method, path, body=None, headers=None, **more):
    connection.request(method, path, body=body, headers=headers or {}, **more)
    answer = connection.getresponse()
    return answer.status, answer.read().decode(), answer


def one_connection():
    for host in ("localhost", "127.0.0.1"):
        connection = http.client.HTTPSConnection(host, port, timeout=20, context=context())
        for i in range(3):
            status, body, _ = ask(connection, "GET", f"/a/{i}?b=c")
            expect((status, body), (200, f"GET /a/{i} "), "GET on a kept connection")
        sock = connection.sock
        expect(ask(connection, "POST", "/b", b"hello")[1], "POST /b hello", "POST with a length")
        pieces = (b"x" * 1000 for _ in range(100))
        expect(ask(connection, "POST", "/c", pieces, encode_chunked=True,
                   headers={"Transfer-Encoding": "chunked"})[1], "POST /c " + "x" * 100_000, "POST in chunks")
        status, body, answer = ask(connection, "HEAD", "/d")
        expect((status, body, answer.getheader("Content-Length")), (200, "", "7"), "HEAD")  # "GET /d "
        expect(connection.sock is sock, True, "the connection was kept")
        status, body, answer = ask(connection, "GET", "/e", headers={"Connection": "close"})
        expect((status, body, answer.getheader("Connection")), (200, "GET /e ", "close"), "the last request")
        connection.close()


def raw(tls):
    """A TLS socket; None if the server refuses."""
    try:
        plain = socket.create_connection(("127.0.0.1", port), timeout=20)
        return tls.wrap_socket(plain, server_hostname="localhost")
    except (ssl.SSLError, ConnectionError):
        return None


def versions():
    warnings.simplefilter("ignore", DeprecationWarning)
    for version, taken in ((ssl.TLSVersion.TLSv1_1, False), (ssl.TLSVersion.TLSv1_2, True),
                           (ssl.TLSVersion.TLSv1_3, True)):
        tls = context()
        tls.minimum_version = tls.maximum_version = version
        tls.set_ciphers("ALL:@SECLEVEL=0")
        sock = raw(tls)
        expect(sock is not None, taken, f"{version.name}")
        if sock:
            expect(sock.compression(), None, "compression")
            sock.close()
    tls = context()
    tls.maximum_version = ssl.TLSVersion.TLSv1_2
    tls.set_ciphers("ECDHE-ECDSA-AES128-SHA256:AES128-SHA")
    expect(raw(tls), None, "ciphers without authenticated encryption or forward secrecy")


def protocols():
    for offered, wanted in ((["http/1.1"], "http/1.1"), (["h2", "http/1.1"], "http/1.1"), (["h2"], None)):
        tls = context()
        tls.set_alpn_protocols(offered)
        sock = raw(tls)
        expect(sock.selected_alpn_protocol() if sock else None, wanted, f"ALPN {offered}")


def stranger():
    try:
        http.client.HTTPSConnection("localhost", port, timeout=20, context=ssl.create_default_context()).request("GET", "/")
        sys.exit("who does not know the authority trusts it")
    except ssl.SSLCertVerificationError:
        pass


one_connection()
versions()
protocols()
stranger()
