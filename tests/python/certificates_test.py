"""Servers of https:// are trusted as curl trusts them."""
import functools
import http.server
import os
import pathlib
import shutil
import ssl
import subprocess
import tempfile
import threading
import unittest

from package import PROGRAM, run_tests, sluice


class Certificates(unittest.TestCase):
    """A server of https:// whose authority the system does not know."""
    VARIABLES = ('CURL_CA_BUNDLE', 'SSL_CERT_FILE', 'SSL_CERT_DIR')

    def setUp(self):
        if shutil.which('openssl') is None:
            self.skipTest('openssl is not installed')
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        subprocess.run('openssl req -x509 -newkey rsa:2048 -nodes -keyout key.pem -out cert.pem -days 2 -subj /CN=localhost'
                       ' -addext subjectAltName=DNS:localhost && mkdir trusted && cp cert.pem trusted &&'
                       ' openssl rehash trusted', shell=True, cwd=folder.name, check=True, capture_output=True)
        subprocess.run([PROGRAM, 'pack', 'synth:shells,dims=20x18x16', '-q', '-o', 'v.zarr'], cwd=folder.name, check=True)
        before = {name: os.environ.pop(name) for name in self.VARIABLES if name in os.environ}
        self.addCleanup(os.environ.update, before)
        handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=folder.name)
        handler.func.log_message = lambda *_: None
        server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), handler)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(self.folder / 'cert.pem', self.folder / 'key.pem')
        server.socket = context.wrap_socket(server.socket, server_side=True)
        server.handle_error = lambda *_: None  # a client that refuses the certificate
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        self.address = f'https://localhost:{server.server_address[1]}/v.zarr'
        try:
            sluice.open(self.address)
        except sluice.Error as error:
            if 'sluice_web.so' in str(error):
                self.skipTest('sluice_web.so is not built')

    def open_with(self, **variables):
        os.environ.update({name: str(self.folder / value) for name, value in variables.items()})
        try:
            return sluice.open(self.address)
        finally:
            for name in variables:
                del os.environ[name]

    def test_are_those_that_the_variables_of_curl_name(self):
        for trusted in [dict(CURL_CA_BUNDLE='cert.pem'), dict(SSL_CERT_FILE='cert.pem'), dict(SSL_CERT_DIR='trusted'),
                        dict(CURL_CA_BUNDLE='cert.pem', SSL_CERT_FILE='missing')]:
            with self.subTest(trusted):
                self.assertEqual(self.open_with(**trusted).dims, (20, 18, 16))

    def test_that_nobody_vouches_for_are_refused(self):
        for variables in [{}, dict(CURL_CA_BUNDLE='missing.pem')]:
            with self.subTest(variables), self.assertRaisesRegex(sluice.Error, 'certificate'):
                self.open_with(**variables)


if __name__ == '__main__':
    run_tests()
