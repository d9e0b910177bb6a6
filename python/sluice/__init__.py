"""Render volumes larger than memory.

    >>> import sluice
    >>> volume = sluice.open('synth:phantom,dims=64x64x64')
    >>> picture = volume.render(size=(256, 192), threshold=40)
    >>> picture.shape, picture.dtype
    ((192, 256, 4), dtype('uint8'))

Options of a picture have the names of the options of `sluice render`, with "_" for "-", and the
same values; their defaults are the command's, and so is the picture. Lengths, places and boxes are
x, y, z. Arrays are indexed [z, y, x], or [time, z, y, x].

Calls may come from any thread, and let other threads run meanwhile. Ctrl-C ends them within a
second. What goes wrong with a file or a request raises sluice.Error, in one line.
"""

import inspect as _inspect
import json as _json
import os as _os

import numpy as _numpy

from . import _arguments, _environment, _notebook, _sluice
from ._sluice import Cancelled, Error, __version__

__all__ = ['Cancelled', 'Error', 'Renderer', 'Volume', 'from_array', 'from_function', 'open', 'simulate']


def open(path, *, time=0, whole_series=True, opens_soon=False, index_dir=None, levels=None, cache=None, cache_dir=None,
         block=None, page=None, memory=None, threads=None, progress=None, **options):
    """Opens a volume and returns a Volume.

    `path` is what `sluice render` takes: a file, a folder, a pattern such as 'step_%03d.nrrd', an
    address, or 'synth:phantom'; or a list of them, each a slice or a time step. `dims` (x, y, z),
    `type` ('u8', 'i16', 'f32', ...), `endian` ('little' or 'big'), `skip` (bytes before the first
    voxel) and `time_steps` are for raw files. `spacing` (x, y, z) replaces the file's. `grid` names
    a grid of OpenVDB or a series of DICOM. `channel` is a number or a name,
    or a list of them that pictures show together, as they do the active channels of an OME file.
    `over` names the file or address of a second volume, which pictures show at its own place in the
    world: labels over a scan, for example. On the same grid as a first volume of one channel, it is
    blended with it as one medium, unless a picture is asked for with combine='add'.

    The first opening passes over the voxels and keeps an index in `index_dir`, by default the
    folder that `sluice` uses; '' keeps none. `memory` ('512M' or bytes) bounds that pass. `levels`
    says whether it makes coarser levels of a file that has none: 'auto' if it is large, 'always',
    'none', or, by default, only uses those that were 'kept' before. `cache` ('20G' or bytes) is the
    limit of a folder, `cache_dir`, that keeps what is read from addresses on the web.
    CURL_CA_BUNDLE, SSL_CERT_FILE and SSL_CERT_DIR name the authorities that https:// trusts.
    `block` is the side of the blocks that are read, a power of two, and `page` (x, y, z) the texels
    of a page of textures. `progress(stage, done, total)` is called with 'indexing' or 'decoding' and
    bytes.

    With `opens_soon`, a large or distant volume whose file has coarser levels is opened without that
    pass: the range of values and looks come from a coarse level, which `warnings` says, and pictures
    are drawn from the levels.

        >>> volume = sluice.open('synth:cube,dims=20x16x12')
        >>> volume.dims, volume.dtype
        ((20, 16, 12), dtype('uint8'))
    """
    known = [keyword for keyword, _ in _sluice.volume_keyword_types()]
    for keyword in options:
        if keyword not in known:
            named = [each.name for each in _inspect.signature(open).parameters.values()
                     if each.kind == each.KEYWORD_ONLY]
            raise TypeError(f"unexpected keyword '{keyword}'; there are: {', '.join(known + named)}")
    if not isinstance(path, (str, _os.PathLike, list, tuple)):
        raise TypeError(f'path: expected a name or a list of names, found {path!r}')
    paths = [path] if isinstance(path, (str, _os.PathLike)) else list(path)
    options.update(whole_series=whole_series, opens_soon=opens_soon, time=time, levels=levels, block=block, page=page,
                   memory=_arguments.byte_count(memory), threads=threads)
    options.update(index_dir=_environment.index_folder(index_dir), **_environment.web_cache(cache, cache_dir),
                   **_environment.certificates())
    if any(str(each).startswith('s3://') for each in [*paths, options.get('over')]):
        options.update(_sluice.bucket_access(_os.environ.get))
    channel = options.get('channel')
    if isinstance(channel, (list, tuple)):
        if not channel:
            raise ValueError('channel: expected one or more channels, found none')
        options['channel'] = ','.join(map(str, channel)) if len(channel) > 1 else channel[0]
    for keyword in ('grid', 'channel'):
        if isinstance(options.get(keyword), str) and not options[keyword]:
            raise ValueError(f"{keyword}: expected a name that is not empty, found ''")
    if options.get('time_steps') is not None and options.get('dims') is None:
        raise TypeError('time_steps requires dims')
    return Volume(_sluice.open_files([_arguments.file_name('path', each) for each in paths], options, progress))


def _place(spacing, origin, unit, name):
    for keyword, text in (('unit', unit), ('name', name)):
        _arguments.text(keyword, text)
    return _sluice.ArrayPlace(_arguments.three('spacing', spacing), _arguments.three('origin', origin), unit, name)


def from_array(array, *, spacing=(1, 1, 1), origin=(0, 0, 0), unit='', name='array', memory=None, threads=None,
               progress=None):
    """Opens an array indexed [z, y, x], or [time, z, y, x], as a volume.

    A NumPy array of any strides is used as it is, without a copy; do not change it while the volume
    is open. Other arrays with a shape, a dtype and slicing (zarr, dask, xarray, h5py) are read box
    by box when pictures need them. `spacing` and `origin` are x, y, z. Of a masked array no voxel may
    be masked, since pictures have no place for it: give `array.filled(value)`.

        >>> import numpy
        >>> z, y, x = numpy.mgrid[:32, :32, :32] - 15.5
        >>> ball = (255 * (x * x + y * y + z * z < 150)).astype('u1')
        >>> sluice.from_array(ball, spacing=(1, 1, 2)).render(size=64).shape
        (64, 64, 4)
    """
    options = dict(memory=_arguments.byte_count(memory), threads=threads)
    place = _place(spacing, origin, unit, name)
    array = getattr(array, 'variable', array)  # of xarray: the array without its coordinates
    if _numpy.ma.is_masked(array):
        raise ValueError('array: has masked voxels, which pictures would show; give array.filled(value), with a value '
                         'that does not show, or numpy.nan')
    # NumPy's own `data` is memory, which some types of voxel refuse with a message of their own.
    if not isinstance(array, _numpy.ndarray) and isinstance(getattr(array, 'data', None), _numpy.ndarray):
        array = array.data
    if isinstance(array, _numpy.ndarray):
        return Volume(_sluice.open_array(_numpy.asarray(array), place, options, progress))
    if not all(hasattr(array, name) for name in ('shape', 'dtype', '__getitem__')):
        array = _numpy.asarray(array)
        return Volume(_sluice.open_array(array, place, options, progress))
    has_steps = len(array.shape) == 4
    dtype = _numpy.dtype(array.dtype)

    def fill(time, lo, hi):
        box = tuple(slice(lo[axis], hi[axis]) for axis in (2, 1, 0))
        voxels = array[(time, *box) if has_steps else box]
        return _numpy.ascontiguousarray(voxels, dtype=dtype.newbyteorder('='))

    return Volume(_sluice.open_function(fill, tuple(array.shape), dtype.newbyteorder('='), place, options, progress))


def from_function(fill, shape, dtype, *, spacing=(1, 1, 1), origin=(0, 0, 0), unit='', name='function', memory=None,
                  threads=None, progress=None):
    """Opens a volume whose voxels a function gives whenever they are needed.

    fill(time, lo, hi) returns the voxels from lo to hi, hi not included, both x, y, z, as an array
    of `dtype` indexed [z, y, x]. `shape` is (z, y, x) or (time, z, y, x).

        >>> import numpy
        >>> def ramp(time, lo, hi):
        ...     x = numpy.arange(lo[0], hi[0], dtype='f4')
        ...     return numpy.broadcast_to(x, (hi[2] - lo[2], hi[1] - lo[1], len(x)))
        >>> sluice.from_function(ramp, (16, 16, 16), 'f4').value_range
        (0.0, 15.0)
    """
    def packed(time, lo, hi):
        return _numpy.ascontiguousarray(fill(time, lo, hi), dtype=dtype)

    if not callable(fill):
        raise TypeError(f'fill: expected a function, found {fill!r}')
    sides = _arguments.each_of('shape', shape, 'whole numbers',
                              lambda keyword, side: _arguments.whole(keyword, side, 64))
    options = dict(memory=_arguments.byte_count(memory), threads=threads)
    return Volume(_sluice.open_function(packed, tuple(sides), _numpy.dtype(dtype), _place(spacing, origin, unit, name),
                                        options, progress))


class Volume:
    """A volume that is open for pictures; see open() and from_array()."""

    def __init__(self, handle):
        self._handle = handle
        self._info = handle.info()
        self._own = None  # the renderer of render(), slice() and the like

    def __repr__(self):
        x, y, z = self.dims
        steps = f', {self.time_steps} steps' if self.time_steps > 1 else ''
        return f"<sluice.Volume '{self.name}': {x} x {y} x {z} {self._info['type']}{steps}>"

    def _repr_png_(self):
        return _notebook.png(self.render())

    @property
    def info(self):
        """All that is known of the volume without its voxels, as a dict."""
        return dict(self._info)

    @property
    def name(self):
        return self._info['name']

    @property
    def dims(self):
        """Voxels along x, y, z."""
        return self._info['dims']

    @property
    def shape(self):
        """Of the array of its voxels: (z, y, x), or (time, z, y, x) if there are several steps."""
        steps = (self.time_steps,) if self.time_steps > 1 else ()
        return steps + self.dims[::-1]

    @property
    def dtype(self):
        kind = self._info['type']
        return _numpy.dtype(f'{kind[0]}{int(kind[1:]) // 8}')

    @property
    def spacing(self):
        """World units between neighbouring voxels along x, y, z."""
        return self._info['spacing']

    @property
    def time_steps(self):
        return self._info['time_steps']

    @property
    def value_range(self):
        """The least and the greatest value."""
        return self._info['value_range']

    def histogram(self, bins=256):
        """How often values occur in bins of equal width: counts, and one more edges.

        Beyond 4096 values, voxels are counted in intervals of values and spread evenly over them: bins
        then differ from numpy.histogram()."""
        return self._handle.histogram(_arguments.whole('bins', bins))

    def _renderer(self):
        if self._own is None:
            self._own = Renderer(self)
        return self._own

    def render(self, *, progress=None, **options):
        """Draws a picture; see Renderer.render(). Pictures of one volume share what they have read."""
        return self._renderer().render(progress=progress, **options)

    def save(self, path, *, progress=None, **options):
        """Draws a picture into a file; see Renderer.save()."""
        self._renderer().save(path, progress=progress, **options)

    def plan(self, *, progress=None, **options):
        """The cost of a picture before it is drawn; see Renderer.plan()."""
        return self._renderer().plan(progress=progress, **options)

    def slice(self, axis, at, *, time=0, most=1024):
        """The plane `at` of the axis 'x', 'y' or 'z' as floats; see Renderer.slice()."""
        return self._renderer().slice(axis, at, time=time, most=most)

    def widget(self, **options):
        """A picture for a notebook with sliders that turn it; needs the package ipywidgets.

        `options` are those of render(); the background is black unless they have one. With a
        `threshold` there is a slider for it, too.
        """
        return _notebook.turned_picture(self.render, self.value_range, options)

    def probe(self, right, down, **options):
        """The voxel seen at a point of a picture; see Renderer.probe()."""
        return self._renderer().probe(right, down, **options)


class Renderer:
    """Draws pictures of a volume on a device and within a memory of its own.

        >>> volume = sluice.open('synth:phantom,dims=64x64x64')
        >>> renderer = sluice.Renderer(volume, device='cpu', memory='256M')
        >>> turn = [renderer.render(azimuth=angle, size=64) for angle in range(0, 360, 90)]
        >>> len(turn), renderer.report()['volume_buffer']['evictions']
        (4, 0)

    `device` is 'auto', 'gl' or 'cpu'. `memory` ('512M' or bytes, by default half of the machine's)
    is a hard bound on the voxels in memory.

    `pipeline` has options of `sluice render` for those who study how pictures are made: algorithm,
    merge, partition, occlusion, policy, seed, pages, simd, gl. The pictures are the same but for
    rounding.

        >>> plain = sluice.Renderer(volume, device='cpu', algorithm='conventional', pages=64)
        >>> int(abs(plain.render(size=64).astype(int) - renderer.render(size=64)).max()) <= 1
        True
    """

    def __init__(self, volume, *, device='auto', memory=None, threads=None, **pipeline):
        if not isinstance(volume, Volume):
            raise TypeError(f'volume: expected what open() or from_array() returns, found {type(volume).__name__}')
        self._volume = volume._handle
        self._handle = _sluice.Renderer(volume._handle, _arguments.text('device', device),
                                        _arguments.byte_count(memory), _arguments.whole('threads', threads or 0),
                                        pipeline)

    @_arguments.lists_keywords
    def render(self, *, progress=None, **options):
        """Draws a picture and returns it as bytes of shape (height, width, 4): red, green, blue,
        alpha, not premultiplied; opaque over a `background`.

        `options` have the names and values of the options of `sluice render`:

        {keywords}

        `size` is (width, height) or one number for both, `max_bytes` a number or a text such as
        '512M', and `time_limit` seconds. With depth=True the result is a pair, the second of shape
        (height, width): the distance from the eye in world units, inf where nothing shows.

        progress(stage, done, total) is called with 'drawing' and groups of blocks.

            >>> volume = sluice.open('synth:phantom,dims=64x64x64')
            >>> volume.render(threshold=10, crop=(0, 0, 0, 64, 32, 64), size=64, shade=True).shape
            (64, 64, 4)
            >>> volume.render(zoom=-1)
            Traceback (most recent call last):
            ValueError: zoom: expected a number from 1e-06 to 1000000, found -1
        """
        return self._handle.render(self._volume, progress, **options)

    def save(self, path, *, progress=None, **options):
        """Draws a picture into a PNG or EXR file, in strips if it is large. The file appears whole
        or not at all, and replaces one that is there."""
        self._handle.save(self._volume, _arguments.file_name('path', path), progress, **options)

    def plan(self, *, progress=None, **options):
        """The cost of the picture that render() draws for these options, before it is drawn: a dict
        with the keys of `sluice plan --json`. No voxel is read.

        `blocks` counts those that are empty (white), trimmed (grey) and full (black); `algorithms`
        has the chunks, pages, bytes and binds of each way to trim and merge them; `read` the blocks
        and bytes of voxels that a first picture reads; `memory` the bytes that it takes, and whether
        it fits; `cut` the levels of resolution, if the volume has several; `channels` the plan of
        each channel, if the picture shows several, or a volume over another one.

            >>> plan = sluice.open('synth:phantom,dims=64x64x64').plan(threshold=40)
            >>> plan['read']['voxel_bytes'] <= 66**3, plan['memory']['fits']
            (True, True)
            >>> list(plan['algorithms'])
            ['conventional', 'clipped', 'trimmed', 'merged']
        """
        return self._handle.plan(self._volume, progress, **options)

    def slice(self, axis, at, *, time=0, most=1024):
        """The plane `at` of the axis 'x', 'y' or 'z' as floats, indexed by the other two axes, the
        later one first. Of more than `most` voxels along a side every second, third, ... is taken.
        NaN stays NaN, and values beyond 1e30 become infinite."""
        if axis not in ('x', 'y', 'z'):
            raise ValueError(f"axis: expected 'x', 'y' or 'z', found {axis!r}")
        return self._handle.slice('xyz'.index(axis), _arguments.whole('at', at, 64), _arguments.whole('time', time, 64),
                                  _arguments.whole('most', most))

    def probe(self, right, down, **options):
        """The place that first hides what lies behind it at a point of the picture that render()
        gives for these options, from 0 to 1 to the right and down: a dict of voxel, world and
        value; None if nothing shows there. Places beside a NaN show nothing, and beside an infinite
        voxel the value is infinite."""
        place = _arguments.number('right', right), _arguments.number('down', down)
        return self._handle.probe(self._volume, *place, **options)

    @property
    def look(self):
        """The options of `sluice render` that give the last picture's look, also if it was chosen."""
        return self._handle.look()

    @property
    def device(self):
        """What draws: 'cpu ...' or the OpenGL driver's name."""
        return self._handle.device()

    def record_to(self, path):
        """From now on writes each request of the texture cache into a trace, for simulate(); None
        ends it, and the file appears."""
        self._handle.record_to('' if path is None else _arguments.file_name('path', path))

    def report(self):
        """Times, counters and bytes of the last picture and of the levels of memory, as a dict."""
        return self._handle.report()


def simulate(trace, *, policies=None, sizes=None, format=None, page_bytes=4096, pin=True):
    """Replays a trace of a texture cache through policies and cache sizes in pages.

    Returns the columns of the table that `sluice simulate` prints, as a dict of arrays, one row a
    policy and size, in the units of `--json`; pandas.DataFrame() takes it. `policies` are names such
    as 'lru' (by default all), `sizes` numbers of pages (by default powers of two).

        >>> volume = sluice.open('synth:phantom,dims=64x64x64')
        >>> renderer = sluice.Renderer(volume, device='cpu')
        >>> import os, tempfile
        >>> folder = tempfile.TemporaryDirectory()
        >>> trace = os.path.join(folder.name, 'turn.trace')
        >>> renderer.record_to(trace)
        >>> for angle in (0, 90):
        ...     _ = renderer.render(azimuth=angle, size=64)
        >>> renderer.record_to(None)
        >>> table = sluice.simulate(trace, policies=['lru', 'belady'], sizes=[4096])
        >>> [str(policy) for policy in table['policy']]
        ['lru', 'belady']
        >>> folder.cleanup()
    """
    request = _sluice.SimulationRequest()
    request.trace = _arguments.file_name('trace', trace)
    request.policies = _arguments.each_of('policies', policies or [], 'names', _arguments.text)
    request.sizes = _arguments.each_of('sizes', [] if sizes is None else sizes, 'whole numbers',
                                       lambda keyword, size: _arguments.whole(keyword, size, 64, 1))
    request.format = None if format is None else _arguments.text('format', format)
    request.page_bytes = _arguments.whole('page_bytes', page_bytes, 64, 1)
    request.pins = bool(pin)
    rows = _json.loads(_sluice.simulate(request))['rows']
    return {name: _numpy.array([row[name] for row in rows]) for name in rows[0]}
