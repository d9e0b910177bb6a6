"""Pictures as notebooks show them, also turned by sliders."""

import struct
import zlib

import numpy


def png(rgba):
    """The bytes of a PNG file of a picture."""
    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))

    height, width = rgba.shape[:2]
    rows = numpy.zeros((height, 1 + 4 * width), 'u1')  # a filter of 0 before each row
    rows[:, 1:] = rgba.reshape(height, -1)
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 6, 0, 0, 0)) +
            chunk(b'IDAT', zlib.compress(rows.tobytes(), 6)) + chunk(b'IEND', b''))


def turned_picture(render, value_range, options):
    """The widget of Volume.widget(); `render` draws a picture."""
    try:
        import ipywidgets
    except ImportError:
        raise ImportError('sluice: the widget needs the package ipywidgets (python3-ipywidgets)') from None
    options = {'fit': 'volume', 'background': '000000', **options}

    def slider(name, low, high, at, step):
        return ipywidgets.FloatSlider(value=options.pop(name, at), min=low, max=high, step=step, description=name)

    sliders = {'azimuth': slider('azimuth', -180, 180, 0, 5), 'elevation': slider('elevation', -90, 90, 0, 5)}
    if options.get('threshold') is not None:
        low, high = value_range
        sliders['threshold'] = slider('threshold', low, high, None, (high - low) / 255 or 1)
    # A box stretches what it holds: a pixel of the picture shall be one of the screen.
    image = ipywidgets.Image(format='png', layout={'align_self': 'flex-start'})

    def draw(_=None):
        image.value = png(render(**options, **{name: each.value for name, each in sliders.items()}))

    for each in sliders.values():
        each.observe(draw, 'value')
    draw()
    return ipywidgets.VBox([image, *sliders.values()])
