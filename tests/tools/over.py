#!/usr/bin/env python3
"""A volume and others over it as NRRD files, written by NumPy, and differences of pictures.

  over.py write          writes scan.nrrd, spot.nrrd, turned.nrrd, labels.nrrd, and more
  over.py compare A B..  prints the largest difference of A and the sum of the others, and A's brightest value; of
                         several such lists with / between them a line each
  over.py hues PICTURE   prints how many of red, green and blue are the only bright one of 20 pixels or more
"""
import sys

import numpy as np
from PIL import Image

N, SPACING, ORIGIN = 48, 2.0, np.array([10.0, -5.0, 7.0])


def nrrd(name, voxels, directions, origin, space='right-anterior-superior', unit='mm', steps=1):
    def vector(numbers):
        return '(' + ','.join(repr(float(n)) for n in numbers) + ')'
    sizes = ' '.join(str(n) for n in voxels.shape[::-1])
    header = f"""NRRD0004
type: {voxels.dtype.name}
endian: little
dimension: {voxels.ndim}
{'space: ' + space if space else 'space dimension: 3'}
sizes: {sizes}
space directions: {' '.join(map(vector, directions))}{' none' if voxels.ndim == 4 else ''}
space units: "{unit}" "{unit}" "{unit}"
space origin: {vector(origin)}
encoding: raw

"""
    with open(name, 'wb') as file:
        file.write(header.encode() + np.ascontiguousarray(voxels).tobytes())


def write():
    z, y, x = np.mgrid[0:N, 0:N, 0:N].astype(float)

    def ball(center, radii):
        away = [((a - c) / r)**2 for a, c, r in zip((x, y, z), center, radii)]
        return (255 * np.exp(-sum(away))).astype('u1')
    axes = np.eye(3) * SPACING
    scan = ball((22, 21, 26), (9, 13, 8))
    nrrd('scan.nrrd', scan, axes, ORIGIN)
    nrrd('scan16.nrrd', 100 * scan.astype('u2'), axes, ORIGIN)
    spot = ball((33, 15, 30), (5, 6, 7))
    nrrd('spot.nrrd', spot, axes, ORIGIN)
    # The same spot with its axes in another order, x from its end, in LPS and micrometers.
    turned = np.transpose(spot[:, :, ::-1], (2, 0, 1))
    origin = ORIGIN + axes[0] * (N - 1)
    flip = np.diag([-1.0, -1.0, 1.0])
    nrrd('turned.nrrd', turned, [1000 * flip @ d for d in (axes[1], axes[2], -axes[0])], 1000 * flip @ origin,
         'left-posterior-superior', 'um')
    labels = np.zeros((N, N, N), 'u1')
    labels[10:20, 10:20, 10:20], labels[10:20, 30:40, 10:20], labels[30:40, 10:40, 30:40] = 1, 2, 7
    nrrd('labels.nrrd', labels, axes, ORIGIN)
    # The same voxels in other words: axes without a meaning, and the labels in LPS and micrometers.
    nrrd('silent.nrrd', spot, axes, ORIGIN, space='')
    nrrd('moved.nrrd', labels, [1000 * flip @ d for d in axes], 1000 * flip @ ORIGIN, 'left-posterior-superior', 'um')
    nrrd('apart.nrrd', spot, axes, ORIGIN + 1000)
    nrrd('bare.nrrd', spot, axes, ORIGIN + 3, unit='')
    nrrd('micro.nrrd', spot, axes, ORIGIN, unit='um')
    nrrd('copied.nrrd', labels, axes, ORIGIN, unit='')
    nrrd('steps.nrrd', np.stack([spot, spot]), axes, ORIGIN)
    with open('table.txt', 'w') as table:
        table.write('1 255 0 0 1 1 1 "one"\n2 0 255 0 1 1 1 "two"\n7 0 0 255 1 1 1 "seven"\n')


def picture(name):
    return np.asarray(Image.open(name).convert('RGB')).astype(int)


if sys.argv[1] == 'write':
    write()
elif sys.argv[1] == 'compare':
    for names in ' '.join(sys.argv[2:]).split(' / '):
        name, *more = names.split()
        first, others = picture(name), sum(picture(other) for other in more)
        print(np.abs(first - np.minimum(others, 255)).max(), first.max())
else:
    pixels = picture(sys.argv[2])
    print(sum(np.count_nonzero((pixels[..., c] > 100) & (pixels[..., (c + 1) % 3] < 20) &
                               (pixels[..., (c + 2) % 3] < 20)) >= 20 for c in range(3)))
