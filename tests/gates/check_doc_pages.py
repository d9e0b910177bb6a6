#!/usr/bin/env python3
"""The documents as pages (tools/docs.sh): each file has its page, search knows it, and no link is broken.

  check_doc_pages.py ROOT
"""
import html.parser
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import urllib.parse


class Links(html.parser.HTMLParser):
    """The targets of a page's links and pictures, and the places in it that links may name."""

    def __init__(self, text):
        super().__init__()
        self.targets, self.places = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == 'id':
                self.places.add(value)
            elif (tag, name) in (('a', 'href'), ('img', 'src'), ('script', 'src'), ('link', 'href')) and value:
                self.targets.append(value)


def check(root, site):
    """A list of complaints about the pages in `site`."""
    complaints = []
    pages = {path.relative_to(site): Links(path.read_text()) for path in site.glob('*.html')}
    index = json.loads((site / 'search/search_index.json').read_text())
    known = {entry['location'].split('#')[0] for entry in index['docs']}
    for source in [*root.glob('*.md'), *(root / 'docs').glob('*.md')]:
        page = 'index.html' if source.name == 'README.md' else source.stem + '.html'
        if pathlib.Path(page) not in pages:
            complaints.append(f'{source.relative_to(root)}: has no page')
        elif page not in known:
            complaints.append(f'{source.relative_to(root)}: search does not know it')
        elif page not in pages[pathlib.Path('index.html')].targets:
            complaints.append(f'{source.relative_to(root)}: is not in the list of pages of tools/docs/mkdocs.yml')
    for page, links in pages.items():
        for target in links.targets:
            url = urllib.parse.urlsplit(target)
            if url.scheme or url.netloc or str(page) == '404.html':
                continue
            path = pathlib.Path(urllib.parse.unquote(url.path)) if url.path else page
            if not (site / path).exists():
                complaints.append(f'{page}: {target} does not exist')
            elif url.fragment and path in pages and url.fragment not in pages[path].places:
                complaints.append(f'{page}: {target} names no heading')
    return complaints


if __name__ == '__main__':
    if shutil.which('mkdocs') is None:
        print('mkdocs is not installed (tools/setup.sh installs it)')
        sys.exit(77)
    top = pathlib.Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([top / 'tools/docs.sh', '--site-dir', folder], check=True)
        found = check(top, pathlib.Path(folder))
    print('\n'.join(found))
    sys.exit(1 if found else 0)
