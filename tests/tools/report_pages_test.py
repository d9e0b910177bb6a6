#!/usr/bin/env python3
"""Pages of --report and `bench report`: valid HTML by an independent validator (tidy), and no word on a browser's console
(Chromium, which is not among what tools/setup.sh installs: 400 MB). Skipped, by name, where neither is; SLUICE_PAGES keeps
the pages and their pictures in light, in dark and on paper for people."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

PROGRAM = sys.argv[1]
VOLUME = ['synth:shells,dims=64x56x48']
SERIES = ['synth:mixing,dims=24x24x24,steps=3']


def run(folder, *words):
    environment = dict(os.environ, XDG_CACHE_HOME=f'{folder}/cache')
    subprocess.run([PROGRAM, *map(str, words)], cwd=folder, check=True, env=environment, stdout=subprocess.DEVNULL)


def make(folder):
    """Every kind of page."""
    run(folder, 'render', *VOLUME, '-o', 'p.png', '--size', '200x150', '--report', 'render.html', '--trace', 'frame.trace')
    run(folder, 'render', *SERIES, '-o', 'p_%02d.png', '--size', '80x60', '--report', 'series.html')
    run(folder, 'plan', *VOLUME, '--report', 'plan.html')
    run(folder, 'simulate', 'frame.trace', '--report', 'simulate.html')
    run(folder, 'bench', 'render', *VOLUME, '--size', '60x50', '--frames', 3, '--report', 'bench.html')
    for name in ('before.json', 'after <b>&.json'):
        run(folder, 'bench', 'render', *VOLUME, '--size', '60x50', '--frames', 3, '--report', name)
    run(folder, 'bench', 'report', 'before.json', 'after <b>&.json', '-o', 'runs.html')
    pages = sorted(pathlib.Path(folder).glob('*.html'))
    assert len(pages) == 6, pages
    return pages


def complaints(page):
    """Of the validator, warnings too."""
    found = subprocess.run(['tidy', '-quiet', '-errors', '-utf8', '--drop-empty-elements', 'no', str(page)], capture_output=True, text=True,
                           check=False)
    return [] if found.returncode == 0 else found.stderr.splitlines() or [f'status {found.returncode}']


def chromium(browser, scratch, *words):
    # Nothing outside: a page that wants the network says so on the console.
    return subprocess.run([browser, '--headless', '--no-sandbox', '--disable-gpu', '--enable-logging=stderr', '--hide-scrollbars',
                           '--host-resolver-rules=MAP * ~NOTFOUND', f'--user-data-dir={scratch}/browser', *words],
                          capture_output=True, text=True, check=False, timeout=120)


def said_on_console(browser, page, scratch):
    ran = chromium(browser, scratch, '--dump-dom', page.as_uri())
    assert ran.returncode == 0 and '</html>' in ran.stdout, f'{page.name}: {browser} ends with {ran.returncode}: {ran.stderr[-500:]}'
    return [line for line in ran.stderr.splitlines() if 'CONSOLE' in line or 'net_error' in line]


def picture_of(browser, page, scratch, pages):
    for name, words in {'light': [], 'dark': ['--force-dark-mode', '--blink-settings=preferredColorScheme=0']}.items():
        chromium(browser, scratch, *words, '--window-size=1000,1600', f'--screenshot={pages}/{page.stem}_{name}.png', page.as_uri())
    chromium(browser, scratch, '--no-pdf-header-footer', f'--print-to-pdf={pages}/{page.stem}.pdf', page.as_uri())


def test(folder, browser):
    pages = make(folder)
    for page in pages:
        text = page.read_text(encoding='utf-8')
        # Namespaces of SVG are names, not addresses to load.
        outside = [url for url in re.findall(r'(?:src|href)="([^"#][^"]*)"', text) if not url.startswith('data:')]
        assert not outside, f'{page.name} loads {outside}'
    broken = pathlib.Path(folder, 'broken.htm')
    broken.write_text('<!DOCTYPE html><html lang="en"><head><title>t</title></head><body><p><b>a</p>'
                      '<script>console.error("broken")</script></body></html>', encoding='utf-8')
    if shutil.which('tidy'):
        assert complaints(broken), 'the validator finds nothing'
        for page in pages:
            assert not complaints(page), f'{page.name}: {complaints(page)}'
    else:
        print('missing: tidy')
    if browser is None:
        print('missing: chromium')
        return
    assert said_on_console(browser, broken, folder), 'the console is not heard'
    for page in pages:
        said = said_on_console(browser, page, folder)
        assert not said, f'{page.name}: {said}'
        if 'SLUICE_PAGES' in os.environ:
            shutil.copy(page, os.environ['SLUICE_PAGES'])
            picture_of(browser, page, folder, os.environ['SLUICE_PAGES'])


if __name__ == '__main__':
    found = next(filter(None, map(shutil.which, ('chromium', 'chromium-browser', 'google-chrome'))), None)
    if found is None and shutil.which('tidy') is None:
        print('missing: tidy, chromium')
        sys.exit(77)
    with tempfile.TemporaryDirectory() as scratch:
        test(scratch, found)
