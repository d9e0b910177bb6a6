"""mkdocs: pages of the top of the repository beside those of docs/, and their links."""
import pathlib
import re

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
