"""Volumes of arrays and of functions have the voxels of NumPy, zarr, dask and xarray."""
import gc
import importlib.util
import unittest

import numpy

from package import ball, run_tests, sluice


class Arrays(unittest.TestCase):
    def picture(self, array):
        return sluice.from_array(array).render(size=40, threshold=20)

    def test_of_every_order_and_sign_are_borrowed(self):
        array = ball()
        expected = self.picture(array)
        wide = numpy.zeros([2 * n for n in array.shape], 'u1')
        wide[::2, ::2, ::2] = array
        read_only = array.copy()
        read_only.flags.writeable = False
        for name, view in [('Fortran', numpy.asfortranarray(array)), ('every second', wide[::2, ::2, ::2]),
                           ('read only', read_only), ('mirrored twice', array[::-1, :, ::-1].copy()[::-1, :, ::-1]),
                           ('transposed', numpy.ascontiguousarray(array.transpose(2, 0, 1)).transpose(1, 2, 0))]:
            with self.subTest(name):
                self.assertTrue((view == array).all())
                self.assertTrue((self.picture(view) == expected).all())

    def test_of_every_type_have_their_values(self):
        for dtype in ['?', 'u1', 'i1', 'u2', 'i2', 'u4', 'i4', 'f4', 'f8']:
            with self.subTest(dtype):
                array = ball(dtype)
                volume = sluice.from_array(array)
                self.assertEqual(volume.shape, array.shape)
                self.assertEqual(volume.value_range, (array.min(), array.max()))
                plane = volume.slice('z', 10)
                self.assertTrue((plane == array[10].astype('f4')).all())
                self.assertTrue((volume.slice('x', 5) == array[:, :, 5].astype('f4')).all())
                self.assertTrue((volume.slice('y', 7) == array[:, 7].astype('f4')).all())

    def test_with_several_steps_are_series(self):
        steps = numpy.stack([ball(), 2 * ball()])
        volume = sluice.from_array(steps)
        self.assertEqual((volume.time_steps, volume.shape), (2, steps.shape))
        self.assertTrue((volume.slice('z', 9, time=1) == steps[1, 9]).all())

    def test_that_are_no_volume_are_refused(self):
        for array, error, words in [
            (numpy.zeros((4, 4)), ValueError, '2 axes'), (numpy.zeros((2, 2, 2, 2, 2)), ValueError, '5 axes'),
            (numpy.zeros((4, 0, 4)), ValueError, 'at least one voxel'),
            (numpy.zeros((4, 4, 4), 'c8'), TypeError, 'complex64'),
            (numpy.zeros((4, 4, 4), 'f2'), TypeError, 'float16'),
            (numpy.zeros((4, 4, 4), 'i8'), TypeError, 'int64'),
            (numpy.zeros((4, 4, 4), '>f4'), TypeError, 'byte order'),
            (numpy.zeros((4, 4, 4), 'U3'), TypeError, '<U3'),
            (numpy.zeros((4, 4, 4), 'c16'), TypeError, r'complex128; give .* numpy.abs\(array\)'),
            (numpy.zeros((4, 4, 4), 'M8[s]'), TypeError, r'datetime64\[s\]; convert them, as with \(array - '),
            (numpy.zeros((4, 4, 4), 'm8[ns]'), TypeError, r'timedelta64\[ns\]; convert'),
            (numpy.zeros((4, 4, 4), 'O'), TypeError, 'found object; convert'),
            (numpy.zeros((4, 4, 4), [('a', 'u1'), ('b', 'f4')]), TypeError, r"give one field, as array\['a'\]")]:
            with self.subTest(words), self.assertRaisesRegex(error, words):
                sluice.from_array(array)
        fields = numpy.zeros((4, 4, 4), [('a', 'u1'), ('b', 'f4')])
        self.assertEqual(sluice.from_array(fields['b']).value_range, (0, 0))
        with self.assertRaisesRegex(sluice.Error, 'spacing'):
            sluice.from_array(ball(), spacing=(1, 0, 1))

    def test_of_the_smallest_numbers_have_a_warning(self):
        for values in (ball('f4') * numpy.float32(1e-42), -ball('f8') * 1e-42):
            self.assertRegex(' '.join(sluice.from_array(values).info['warnings']), 'closer to 0 than 1.2e-38')
        self.assertEqual(sluice.from_array(ball('f4') * numpy.float32(1e-5)).info['warnings'], [])
        self.assertEqual(sluice.from_array(ball('f4') * 0).info['warnings'], [])

    def test_stay_while_the_volume_is_open(self):
        expected = self.picture(ball())
        volume = sluice.from_array(ball())
        gc.collect()
        junk = [numpy.full(100_000, 255, 'u1') for _ in range(20)]
        self.assertTrue((volume.render(size=40, threshold=20) == expected).all())
        del junk

    def test_of_zarr_are_read_box_by_box(self):
        try:
            import zarr
        except ImportError:
            self.skipTest('python3-zarr is not installed')
        array = ball('i2', 40)
        stored = zarr.array(array, chunks=(16, 16, 16))
        volume = sluice.from_array(stored)
        self.assertTrue((volume.render(size=40, threshold=20) == self.picture(array)).all())

    def test_of_dask_are_computed_box_by_box(self):
        try:
            import dask.array
        except ImportError:
            self.skipTest('python3-dask is not installed')
        array = ball('i2', 40)
        computed = []

        def seen(block):
            computed.append(block.shape)
            return block

        lazy = dask.array.from_array(array, chunks=(16, 16, 16)).map_blocks(seen, dtype='i2', meta=array[:0])
        volume = sluice.from_array(lazy)
        self.assertTrue((volume.render(size=40, threshold=20) == self.picture(array)).all())
        self.assertLessEqual(max(computed), (16, 16, 16))

    def test_of_xarray_are_those_inside(self):
        try:
            import xarray
        except ImportError:
            self.skipTest('python3-xarray is not installed')
        array = ball('i2', 40)
        named = xarray.DataArray(array, dims=('z', 'y', 'x'), coords={'x': numpy.arange(array.shape[2]) * 0.5}, name='ball')
        kinds = [named, named.transpose('x', 'y', 'z').transpose('z', 'y', 'x')]
        if importlib.util.find_spec('dask') is not None:
            kinds.append(named.chunk(16))
        for each in kinds:
            volume = sluice.from_array(each)
            self.assertTrue((volume.render(size=40, threshold=20) == self.picture(array)).all())

    def test_that_a_function_gives_may_fail(self):
        calls = []

        def fill(time, lo, hi):
            calls.append((lo, hi))
            if len(calls) > 1:
                raise KeyError('gone')
            return numpy.zeros(tuple(hi[a] - lo[a] for a in (2, 1, 0)), 'u1')

        with self.assertRaisesRegex(KeyError, 'gone'):
            sluice.from_function(fill, (200, 200, 200), 'u1', threads=1).render(size=16, threshold=0)
        with self.assertRaisesRegex(ValueError, 'contiguous array'):
            sluice.from_function(lambda time, lo, hi: numpy.zeros((1, 1, 1), 'u1'), (30, 30, 30), 'u1')

    def test_have_numpys_histogram(self):
        array = ball()
        counts, edges = sluice.from_array(array).histogram(16)
        self.assertEqual(int(counts.sum()), array.size)
        self.assertEqual((edges[0], edges[-1]), (array.min(), array.max()))


if __name__ == '__main__':
    run_tests()
