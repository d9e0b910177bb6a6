"""Writes small zip files with numbers of 32 and of 64 bits: make_zip_seeds.py FOLDER."""
import pathlib
import sys
import zipfile

folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
for name, limits, method in [("narrow", (2**31, 65535), zipfile.ZIP_DEFLATED), ("wide", (1, 1), zipfile.ZIP_STORED)]:
    zipfile.ZIP64_LIMIT, zipfile.ZIP_FILECOUNT_LIMIT = limits
    with zipfile.ZipFile(folder / name, "w", method) as out:
        out.comment = b"of " + name.encode()
        for key in (".zgroup", "0/.zarray", "0/0/0/0", "0/0/0/1"):
            out.writestr(key, key * 3)
