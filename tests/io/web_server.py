#!/usr/bin/env python3
"""A web server of a folder's files that misbehaves as asked.

  web_server.py FOLDER LOG [FAULT]

Prints its port, then serves until its input ends. LOG gets a line for each request: the path, the
range, the status and the bytes of the body. An ETag that is sent back is answered by 304. Every third request for a chunk goes wrong, by FAULT:

  drop      the connection is closed half way
  silent    the connection is closed without an answer
  delay     50 ms before each answer, and none goes wrong
  busy      status 429, with Retry-After: 0
  broken    status 503
  whole     200 and the whole object where a part was asked for, always
  whole-drop  the same, and the first answer to such a request breaks off half way
  whole-cut   the same, and the answers to other requests break off half way
  long      a Content-Length that is larger than what comes
  changed   from the twentieth request on, every object has another ETag
  forbidden status 403 for what is not there
  gzip      a Content-Encoding
  moved     an object is found below /moved/, and the server says so
  to=URL    every object is found on another server, and this one says so
  loop      the server says of every place that an object is found elsewhere
  late      the first connection gets no answer
  stall-metadata, stall-levels, stall-chunks  an answer of that kind ends half way, and its connection stays
  deaf      no answer begins
  down      status 500 for everything
  later     status 503, with Retry-After: 5, for each chunk
  trickle   a byte each half second
  shaped    answers begin after 50 ms, and all together send 100 Mbit/s at most, and none goes wrong
"""
import http.server
import pathlib
import sys
import threading
import time

folder, log = pathlib.Path(sys.argv[1]), open(sys.argv[2], 'w', buffering=1)
fault = sys.argv[3] if len(sys.argv) > 3 else ''
lock = threading.Lock()
counted = {'all': 0, 'chunks': 0, 'parts': 0}
shaped_bytes_a_second = 100e6 / 8
line_is_free_at = [0.0]  # of the shaped line


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = 'HTTP/1.1'
    disable_nagle_algorithm = True

    def log_message(self, *_):
        pass

    def send_shaped(self, part):
        """Sends in small pieces, each when the line has had the time for it."""
        for at in range(0, len(part), 16384):
            piece = part[at:at + 16384]
            with lock:
                begins = max(line_is_free_at[0], time.monotonic())
                line_is_free_at[0] = begins + len(piece) / shaped_bytes_a_second
                ends = line_is_free_at[0]
            time.sleep(max(0, ends - time.monotonic()))
            self.wfile.write(piece)

    def part_of(self, size):
        """First and last byte of the range, and whether there is one."""
        asked = self.headers.get('Range')
        if not asked or fault.startswith('whole'):
            return 0, size - 1, False
        first, last = asked.removeprefix('bytes=').split('-')
        if first == '':
            return max(0, size - int(last)), size - 1, True
        return int(first), min(int(last or size - 1), size - 1), True

    def do_GET(self):
        path = self.path.split('?')[0].lstrip('/')
        file = folder / path
        to = None
        if fault == 'moved' and path.startswith('moved/'):
            file = folder / path.removeprefix('moved/')
        elif fault in ('moved', 'loop'):
            to = '/moved/' + path
        elif fault.startswith('to='):
            to = fault.removeprefix('to=') + '/' + path
        if to:
            log.write(f'{path} {self.headers.get("Range", "-")} 302 5 {self.headers.get("Authorization", "-")}\n')
            self.send_response(302)
            self.send_header('Location', to)
            self.send_header('Content-Length', '5')
            self.end_headers()
            self.wfile.write(b'there')
            return
        with lock:
            counted['all'] += 1
            is_chunk = not file.name.startswith(('.z', 'zarr.json'))
            counted['chunks'] += is_chunk
            goes_wrong = is_chunk and (counted['chunks'] % 3 == 0 or fault == 'later')
            if fault.startswith('whole-'):
                counted['parts'] += 'Range' in self.headers
                goes_wrong = is_chunk and (
                    fault == 'whole-drop' and counted['parts'] == 1 and 'Range' in self.headers or
                    fault == 'whole-cut' and 'Range' not in self.headers)
            stamp = 'second' if fault == 'changed' and counted['all'] >= 20 else 'first'
        if fault == 'deaf':
            log.write(f'{path} - 0 0 -\n')
        if fault == 'deaf' or fault == 'late' and counted['all'] == 1:
            time.sleep(60)
        if fault in ('delay', 'shaped'):
            time.sleep(0.05)
        status = 200
        if fault == 'down':
            status = 500
        elif not file.is_file():
            status = 403 if fault == 'forbidden' else 404
        elif goes_wrong and fault in ('busy', 'broken', 'later'):
            status = 429 if fault == 'busy' else 503
        if status != 200:
            body, first, last, is_part = b'no', 0, 1, False
        else:
            body = file.read_bytes()
            tag = f'"{stamp}-{len(body)}-{file.stat().st_mtime_ns}"'
            first, last, is_part = self.part_of(len(body))
            if is_part and first >= len(body):
                status, body, is_part = 416, b'', False
            elif is_part:
                status = 206
            if self.headers.get('If-None-Match') == tag:
                status, body, first, last, is_part = 304, b'', 0, -1, False
        part = body[first:last + 1]
        log.write(f'{path} {self.headers.get("Range", "-")} {status} {len(part)} '
                  f'{self.headers.get("Authorization", "-")}\n')
        if goes_wrong and fault == 'silent':
            self.close_connection = True
            return
        self.send_response(status)
        if status != 304:
            self.send_header('Content-Length', str(len(part) + (100 if goes_wrong and fault == 'long' else 0)))
        if is_part:
            self.send_header('Content-Range', f'bytes {first}-{last}/{len(body)}')
        elif status == 416:
            self.send_header('Content-Range', f'bytes */{file.stat().st_size}')
        if status in (200, 206, 304):
            self.send_header('ETag', tag)
        if fault in ('busy', 'later') and status in (429, 503):
            self.send_header('Retry-After', '0' if fault == 'busy' else '5')
        if fault == 'gzip':
            self.send_header('Content-Encoding', 'gzip')
        self.end_headers()
        if goes_wrong and fault in ('drop', 'whole-drop', 'whole-cut'):
            part = part[:len(part) // 2]
        kinds = ['stall-chunks'] if is_chunk else ['stall-metadata']
        if not is_chunk and file.parent.name.isdigit() and file.parent.name != '0':
            kinds.append('stall-levels')
        if fault in kinds and status in (200, 206):
            self.wfile.write(part[:len(part) // 2])
            time.sleep(60)
        if fault == 'trickle':
            for byte in part:
                self.wfile.write(bytes([byte]))
                time.sleep(0.5)
        elif fault == 'shaped':
            self.send_shaped(part)
        else:
            self.wfile.write(part)
        if goes_wrong and fault in ('drop', 'long', 'whole-drop', 'whole-cut'):
            self.close_connection = True


http.server.ThreadingHTTPServer.request_queue_size = 64
server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), Handler)
server.daemon_threads = True
server.handle_error = lambda *_: None  # connections that the client gives up
threading.Thread(target=server.serve_forever, daemon=True).start()
print(server.server_port, flush=True)
sys.stdin.read()
