"""The stored numbers of DICOM files as pydicom has them, with GDCM for what is compressed.

decode_dicom.py FOLDER FILE...: for each file FOLDER/<name>.bin, x fastest, frame after frame, in this
machine's byte order.
"""

import os
import sys
import warnings

import gdcm  # noqa: F401, so that pydicom has it
import pydicom

warnings.simplefilter("ignore")
for path in sys.argv[2:]:
    d = pydicom.dcmread(path, force=True)
    pixels = d.pixel_array
    pixels = pixels.astype(pixels.dtype.newbyteorder("="))
    pixels.tofile(os.path.join(sys.argv[1], os.path.basename(path) + ".bin"))
