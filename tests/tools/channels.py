#!/usr/bin/env python3
"""Volumes of several channels by zarr-python and tifffile, and sums of pictures by NumPy.

  channels.py write            writes cells.ome.zarr, cells.ome.tif, flat.ome.zarr, deep.ome.zarr,
                               eight.ome.zarr, moving.ome.zarr, and plain.ome.tif and plain.tif, which have
                               no colours, into this folder
  channels.py sum WHOLE PART.. prints the largest difference of WHOLE and the sum of the PARTs, in 1/255; of several
                               such lists with / between them a line each
  channels.py flat WHOLE       the same of WHOLE and the projection of flat.ome.zarr
  channels.py deep WHOLE       the same of WHOLE and deep.ome.zarr, blended
"""
import sys

import numpy as np
from PIL import Image

COLORS = {'DAPI': '00FFFF', 'Actin': '00FF00', 'Spots': 'FF00FF', 'Dust': 'FFFFFF'}
WINDOWS = {'DAPI': (400, 3000), 'Actin': (400, 2000), 'Spots': (500, 5000), 'Dust': (0, 65535)}


def cells():
    """Balls in shells with spots in 16 bits: channel, z, y, x; the fourth is dust that nobody wants to see."""
    z, y, x = np.mgrid[0:20, 0:70, 0:80].astype('f4')
    choose = np.random.default_rng(1)
    channels = np.zeros((4,) + z.shape, 'f4')
    for _ in range(6):
        at = choose.uniform([4, 12, 12], [16, 58, 68])
        away = np.sqrt(((z - at[0]) * 3)**2 + (y - at[1])**2 + (x - at[2])**2)
        channels[0] = np.maximum(channels[0], 3000 * np.clip(1.5 - away / 6, 0, 1))
        channels[1] = np.maximum(channels[1], 2000 * np.clip(1 - np.abs(away - 11) / 3, 0, 1))
    for _ in range(30):
        at = choose.uniform([2, 4, 4], [18, 66, 76])
        away = np.sqrt(((z - at[0]) * 3)**2 + (y - at[1])**2 + (x - at[2])**2)
        channels[2] = np.maximum(channels[2], 5000 * np.clip(1.5 - away / 2, 0, 1))
    noise = np.random.default_rng(2).normal(100, 15, channels.shape)
    return (channels + noise).clip(0, 65535).astype('u2')


def write_zarr(name, voxels):
    import zarr  # takes longer to load than sums take
    group = zarr.open_group(name, mode='w')
    has_time = voxels.ndim == 5
    group.create_dataset('0', data=voxels, chunks=(1, 1, 16, 32, 32)[-voxels.ndim:])
    axes = [dict(name='t', type='time')] * has_time + [dict(name='c', type='channel')]
    axes += [dict(name=n, type='space', unit='micrometer') for n in 'zyx']
    scale = [1] * has_time + ([1, 1.5, 0.5, 0.5] if name.startswith('cells') else [1, 1, 1, 1])
    transform = [dict(type='scale', scale=scale)]
    group.attrs['multiscales'] = [
        dict(version='0.4', axes=axes, datasets=[dict(path='0', coordinateTransformations=transform)])]
    group.attrs['omero'] = dict(channels=[
        dict(label=label, color=COLORS[label], active=label != 'Dust',
             window=dict(start=start, end=end, min=0, max=65535)) for label, (start, end) in WINDOWS.items()])


def write():
    import tifffile
    voxels = cells()
    write_zarr('cells.ome.zarr', voxels)
    # Red, green, blue and alpha in a signed number.
    colors = [np.array(int(c + 'FF', 16), 'u4').astype('i4').item() for c in COLORS.values()]
    tifffile.imwrite('cells.ome.tif', voxels[:3].transpose(1, 0, 2, 3), ome=True, photometric='minisblack',
                     metadata=dict(axes='ZCYX', PhysicalSizeX=0.5, PhysicalSizeXUnit='um', PhysicalSizeY=0.5,
                                   PhysicalSizeYUnit='um', PhysicalSizeZ=1.5, PhysicalSizeZUnit='um',
                                   Channel=dict(Name=list(COLORS)[:3], Color=colors[:3])))
    plain = voxels[:3].transpose(1, 0, 2, 3)
    tifffile.imwrite('plain.ome.tif', plain, ome=True, photometric='minisblack', metadata=dict(axes='ZCYX'))
    tifffile.imwrite('plain.tif', plain, imagej=True, metadata=dict(axes='ZCYX'))
    # The same values all along z, so that any sample of a ray has them.
    image = np.random.default_rng(3).integers(0, 6000, (4, 1, 32, 48)).astype('u2')
    np.save('flat.npy', image[:, 0])
    write_zarr('flat.ome.zarr', np.repeat(image, 6, axis=1))


    eight = np.random.default_rng(5).integers(0, 6000, (8, 6, 32, 48)).astype('u2')
    write_zarr('eight.ome.zarr', eight)
    deep = np.random.default_rng(4).integers(0, 6000, (4, 9, 32, 48)).astype('u2')
    np.save('deep.npy', deep)
    write_zarr('deep.ome.zarr', deep)
    write_zarr('moving.ome.zarr', np.stack([eight[:4], deep[:, :6]]))


def deep():
    """Rays along -z, a pixel a voxel with y up, sampled half way between the voxels; omero's windows, opacity 0.4."""
    voxels = np.load('deep.npy').astype('f8')
    middle = (voxels[:, 1:] + voxels[:, :-1])[:, ::-1, ::-1] / 2
    color, opacity = np.zeros((32, 48, 3)), np.zeros((32, 48, 1))
    for z in range(middle.shape[1]):
        clear, light, total = 1, 0, 0
        for c, (label, (start, end)) in list(enumerate(WINDOWS.items()))[:3]:
            a = 0.4 * np.clip((middle[c, z] - start) / (end - start), 0, 1)[:, :, None]
            clear, total = clear * (1 - a), total + a
            light = light + a * np.array([int(COLORS[label][i:i + 2], 16) for i in (0, 2, 4)])
        a = 1 - clear
        color += (1 - opacity) * light * a / np.maximum(total, 1e-9)
        opacity += (1 - opacity) * a
    return color


def picture(name):
    return np.asarray(Image.open(name).convert('RGB')).astype('f8')


def flat():
    """The projection, a pixel a voxel, with y up."""
    total = np.zeros((32, 48, 3))
    for (label, (start, end)), image in list(zip(WINDOWS.items(), np.load('flat.npy')))[:3]:
        share = np.clip((image - float(start)) / (end - start), 0, 1)[::-1, :, None]
        total += share * np.array([int(COLORS[label][i:i + 2], 16) for i in (0, 2, 4)])
    return np.minimum(total, 255)


if sys.argv[1] == 'write':
    write()
elif sys.argv[1] == 'sum':
    for names in ' '.join(sys.argv[2:]).split(' / '):
        whole, *parts = names.split()
        expected = np.minimum(sum(picture(name) for name in parts), 255)
        print(f'{np.abs(picture(whole) - expected).max():.3f} of {expected.max():.0f}')
elif sys.argv[1] == 'deep':
    inner = (slice(1, -1), slice(1, -1))
    print(f'{np.abs(picture(sys.argv[2]) - deep())[inner].max():.3f} of {deep().max():.0f}')
else:
    # Rays through the outermost voxels may miss the volume.
    inner = (slice(1, -1), slice(1, -1))
    print(f'{np.abs(picture(sys.argv[2]) - flat())[inner].max():.3f} of {flat().max():.0f}')
