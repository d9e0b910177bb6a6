"""mkdocs: pages of the top of the repository beside those of docs/, their links, and the library's headers as
pages, which Doxygen makes (Doxyfile) if it is installed."""
import pathlib
import re
import shutil
import subprocess

from mkdocs.structure.files import File

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINK = re.compile(r'(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)]*)?\)')


def on_files(files, config):
    for path in sorted(ROOT.glob('*.md')):
        files.append(File(path.name, str(ROOT), config['site_dir'], config['use_directory_urls']))
    return files


def on_page_markdown(markdown, page, config, files):
    """Links follow the files to their places; links to sources, which are no pages, become their text."""
    folder = pathlib.Path(page.file.abs_src_path).parent

    def mended(match):
        picture, text, target, anchor = match.groups()
        if '://' in target:
            return match.group()
        path = (folder / target).resolve()
        for top in (ROOT / 'docs', ROOT):
            if path.is_relative_to(top) and files.get_file_from_path(str(path.relative_to(top))):
                return f'{picture}[{text}]({path.relative_to(top)}{anchor or ""})'
        return text

    return LINK.sub(mended, markdown)


def on_page_content(html, page, config, files):
    if page.file.src_path != 'library.md' or shutil.which('doxygen') is None:
        return html
    return html + '<p><a href="api/annotated.html">All classes and functions of the headers</a></p>'


def on_post_build(config):
    if shutil.which('doxygen') is None:
        return
    settings = (ROOT / 'tools/docs/Doxyfile').read_text()
    settings += f'OUTPUT_DIRECTORY = "{config["site_dir"]}"\nHTML_OUTPUT = api\n'
    subprocess.run(['doxygen', '-'], input=settings, text=True, cwd=ROOT, check=True)
