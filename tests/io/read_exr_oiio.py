"""read_exr_oiio.py FILE [PNG]: what OpenImageIO says of an EXR, a line each.

With PNG: the largest difference of the EXR's colours from the PNG's, of 1, after the EXR's linear
light has gone through the transfer function of sRGB, where the PNG shows anything.
"""

import sys

import numpy as np
import OpenImageIO as oiio


def read(path):
    config = oiio.ImageSpec()
    config["oiio:UnassociatedAlpha"] = 1  # straight colours as the PNG has them
    image = oiio.ImageInput.open(path, config)
    assert image, oiio.geterror()
    return image.spec(), image.read_image("float")


spec, pixels = read(sys.argv[1])
print("channels", *spec.channelnames)
print("display", spec.full_x, spec.full_y, spec.full_width, spec.full_height)
print("data", spec.x, spec.y, spec.width, spec.height)
for attribute in spec.extra_attribs:
    value = attribute.value
    if isinstance(value, (tuple, float)):
        numbers = value if isinstance(value, tuple) else (value,)
        value = " ".join("%.6g" % number for number in numbers)
    print("attribute", attribute.name, attribute.type, str(value).replace("\n", " "))

if len(sys.argv) > 2:
    png_spec, png = read(sys.argv[2])
    assert png.shape[:2] == pixels.shape[:2]
    names = list(spec.channelnames)
    r, g, b, alpha = (pixels[:, :, names.index(name)] for name in "RGBA")
    shown = png[:, :, 3] > 0.5 / 255
    assert shown.sum() > 100, "nothing shows"
    worst = np.abs(alpha - png[:, :, 3]).max()
    for channel, linear in enumerate((r, g, b)):
        straight = linear[shown] / alpha[shown]
        srgb = np.where(straight <= 0.0031308, 12.92 * straight,
                        1.055 * np.maximum(straight, 0) ** (1 / 2.4) - 0.055)
        worst = max(worst, np.abs(np.clip(srgb, 0, 1) - png[:, :, channel][shown]).max())
    print("difference %.6f" % worst)
    if "Z" in names:
        depth = pixels[:, :, names.index("Z")]
        print("depth", np.isfinite(depth[shown]).all(), np.isinf(depth[alpha == 0]).all())
