"""Folders and certificates that variables of the environment name, as the program reads them."""

import os

from . import _arguments


def _folder(*places):
    """The first folder that an environment variable names by its absolute path; '' if none does."""
    for variable, below in places:
        folder = os.environ.get(variable, '')
        if folder.startswith('/'):
            return os.path.join(folder, below) if below else folder
    return ''


def index_folder(index_dir):
    """The folder that `sluice` itself keeps indices in, unless another one is named; '' is none.

    SLUICE_INDEX=beside names no folder: an index next to the volume is read in any case.
    """
    if index_dir is not None:
        return _arguments.file_name('index_dir', index_dir) if index_dir else ''
    wish = os.environ.get('SLUICE_INDEX', '')
    if wish not in ('', 'beside', 'off'):
        raise ValueError(f"SLUICE_INDEX: expected off or beside, found '{wish}'")
    if wish == 'off':
        return ''
    folder = os.environ.get('SLUICE_INDEX_DIR', '')
    if folder and not folder.startswith('/'):
        raise ValueError(f"SLUICE_INDEX_DIR: expected the absolute path of a folder, found '{folder}'")
    return folder or _folder(('XDG_CACHE_HOME', 'sluice/index'), ('HOME', '.cache/sluice/index'))


def web_cache(size, folder):
    """The options of the folder for what is read from the web, as --cache and --cache-dir have them."""
    if size is None and folder is None:
        return {}
    own_folder = _folder(('XDG_CACHE_HOME', 'sluice/web'), ('HOME', '.cache/sluice/web'))
    return dict(cache=_arguments.byte_count('20G' if size is None else size, 'cache'),
                cache_dir=_arguments.file_name('cache_dir', folder) if folder is not None else own_folder)


def certificates():
    """The options of the authorities that https:// trusts, from the variables that curl looks at."""
    bundle = os.environ.get('CURL_CA_BUNDLE')
    if bundle:
        return dict(certificate_file=bundle)
    return dict(certificate_file=os.environ.get('SSL_CERT_FILE', ''),
                certificate_folder=os.environ.get('SSL_CERT_DIR', ''))
