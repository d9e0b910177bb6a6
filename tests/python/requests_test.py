"""Requests that are wrong name the keyword, what was expected, and what was found."""
import ast
import os
import pathlib
import tempfile
import unittest
import unittest.mock
import warnings

import numpy

from package import PACKAGE, PHANTOM, ball, run_tests, sluice


class Requests(unittest.TestCase):
    def test_that_are_wrong_name_the_keyword(self):
        volume = sluice.from_array(ball())
        for options, error, words in [
            (dict(colour='red'), TypeError, "unexpected keyword 'colour'"),
            (dict(zoom='much'), TypeError, 'zoom'), (dict(zoom=0), ValueError, 'zoom'),
            (dict(zoom=float('nan')), ValueError, 'zoom'), (dict(size=(0, 4)), ValueError, 'size'),
            (dict(size=1 << 20), sluice.Error, 'size'), (dict(size='big'), TypeError, 'size'),
            (dict(view='inside'), ValueError, "one of 'plain'"), (dict(crop=(0, 0, 0, 4)), ValueError, 'crop'),
            (dict(crop=(0, 0, 0, 400, 4, 4)), ValueError, 'crop'), (dict(time=3), ValueError, 'time'),
            (dict(time=-1), ValueError, 'time'), (dict(map='pinkish'), sluice.Error, 'pinkish'),
            (dict(background='red'), ValueError, 'background'), (dict(eye=(0, 0, 0)), TypeError, 'eye requires target'),
            (dict(threshold=4, labels=True), TypeError, 'threshold and labels'),
            (dict(level=1, pixel_error=2), TypeError, 'level and pixel_error'),
            (dict(opacities=[(5, 0.1), (1, 0.2)]), ValueError, 'opacities'),
            (dict(opacities=[(5, 2)]), ValueError, 'opacities'), (dict(level=-1), ValueError, 'level'),
            (dict(level=5), sluice.Error, 'level'), (dict(transfer='no/such.json'), sluice.Error, 'no/such.json'),
            (dict(full_gradient=0.05), TypeError, 'full_gradient requires modulate'),
            (dict(full_gradient=0.05, modulate=False), TypeError, 'full_gradient requires modulate'),
            (dict(mode='mip', iso=40), TypeError, "^iso needs mode composite, since other modes show one value"),
            (dict(mode='mip', shadows=True), TypeError, '^shadows needs mode composite'),
            (dict(mode='minip', jitter=0.5), TypeError, '^jitter needs mode composite'),
            (dict(mode='average', depth_cueing=1), TypeError, '^depth_cueing needs mode composite'),
            (dict(shade=False, shadows=0.5, occlusion_light=True), TypeError,
             "^shadows lights the picture; leave out shade=False"),
            (dict(modulate='yes'), TypeError, 'modulate: expected True or False'),
            (dict(max_bytes='20 K B'), ValueError, '^max_bytes: expected bytes'),
            (dict(pixel_error=0), ValueError, 'pixel_error'), (dict(depth='yes'), TypeError, 'depth')]:
            with self.subTest(options), self.assertRaisesRegex(error, words):
                volume.render(**options)
        with self.assertRaisesRegex(ValueError, 'device'):
            sluice.Renderer(volume, device='abacus')
        with self.assertRaisesRegex(ValueError, 'memory'):
            sluice.Renderer(volume, memory='lots')
        for call, error, words in [
                (lambda: sluice.Renderer(volume, memory=-1), ValueError, "^memory: expected bytes .*, found -1$"),
                (lambda: sluice.Renderer(volume, memory=float('nan')), ValueError, '^memory: .*, found nan$'),
                (lambda: sluice.Renderer(volume, memory=0), ValueError, '^memory: .*, found 0$'),
                (lambda: sluice.Renderer(volume, memory=1.5), ValueError, '^memory: .*, found 1.5$'),
                (lambda: sluice.open(PHANTOM, cache=-4, cache_dir='c'), ValueError, '^cache: .*, found -4$'),
                (lambda: sluice.Renderer(volume, threads='x'), TypeError, "^threads: .* whole number, found 'x'$"),
                (lambda: sluice.Renderer(volume, device=4), TypeError, '^device: expected a text, found 4$'),
                (lambda: volume.slice('z', 'a'), TypeError, "^at: .* whole number, found 'a'$"),
                (lambda: volume.slice('z', 1, most=1 << 40), ValueError, '^most: .* 32 bits'),
                (lambda: volume.probe('a', 0.5), TypeError, "^right: expected a number, found 'a'$"),
                (lambda: volume.probe(0.5, float('nan')), TypeError, '^down: expected a number, found nan$'),
                (lambda: volume.histogram(2.5), TypeError, '^bins: .* whole number, found 2.5$'),
                (lambda: sluice.from_function(len, ('a', 2, 2), 'f4'), TypeError, '^shape: .* whole number'),
                (lambda: sluice.from_function(4, (4, 4, 4), 'f4'), TypeError, '^fill: expected a function'),
                (lambda: sluice.simulate('t', page_bytes='x'), TypeError, '^page_bytes: '),
                (lambda: sluice.simulate('t', policies='lru'), TypeError, '^policies: expected a list of names'),
                (lambda: sluice.simulate('t', sizes=[0.5]), TypeError, '^sizes: .* whole number'),
                (lambda: sluice.simulate('t', sizes=[-1]), ValueError, '^sizes: .* from 1, found -1$'),
                (lambda: sluice.open(PHANTOM, channel=[]), ValueError, '^channel: expected one or more')]:
            with self.subTest(words), self.assertRaisesRegex(error, words):
                call()
        with self.assertRaisesRegex(sluice.Error, 'no/such/file.nrrd'):
            sluice.open('no/such/file.nrrd')
        for options, error, words in [
                (dict(algorithm='V'), sluice.Error, '^algorithm "V": expected one of conventional, '),
                (dict(pages=3), sluice.Error, '^pages 3: '), (dict(pages='a'), TypeError, '^pages: .*whole number'),
                (dict(policy=4), TypeError, '^policy: expected text, found 4'),
                (dict(seed=-1), TypeError, '^seed: .* from 0, found -1'), (dict(wheels=4), TypeError, 'wheels')]:
            with self.subTest(options), self.assertRaisesRegex(error, words):
                sluice.Renderer(volume, **options)
        for options, error, words in [
                (dict(block=17), sluice.Error, '^block 17: '), (dict(block='x'), TypeError, '^block: .*whole number'),
                (dict(page=(1, 2)), TypeError, '^page: expected three whole numbers'),
                (dict(dims='x'), TypeError, '^dims: '),
                (dict(dims=(4, 4, 4, 1)), ValueError, r'^dims: expected 3 whole numbers \(X,Y,Z\), found '),
                (dict(dims=(4.0, 4, 4)), TypeError, r'^dims: expected 3 whole numbers \(X,Y,Z\), found '),
                (dict(skip=2**60 + 1), ValueError, f'^skip: expected a whole number .* to {2**60}, found '),
                (dict(spacing=2), TypeError, '^spacing: expected 3 numbers'),
                (dict(dims=(4, 0, 1)), ValueError, '^dims: expected a whole number from 1 .*, found 0$'),
                (dict(type='u9'), ValueError, "^type: expected one of 'u8', .*, found 'u9'$"),
                (dict(endian='middle'), ValueError, "^endian: expected one of 'little', 'big', found 'middle'$"),
                (dict(channel=-1), ValueError, '^channel: .*, found -1$'), (dict(channel=1.5), TypeError, '^channel: '),
                (dict(over=4), TypeError, '^over: expected a name'),
                (dict(time_steps=2), TypeError, '^time_steps requires dims$'),
                (dict(grid=''), ValueError, "^grid: expected a name that is not empty, found ''$"),
                (dict(channel=''), ValueError, "^channel: expected a name that is not empty, found ''$"),
                (dict(channel=['']), ValueError, "^channel: expected a name that is not empty, found ''$"),
                (dict(over=''), ValueError, '^over: expected a name'),
                (dict(wheels=4), TypeError, "^unexpected keyword 'wheels'; there are: dims, .*, over, time, .*, threads"),
                (dict(grid=4), TypeError, '^grid: '), (dict(opens_soon='x'), TypeError, '^opens_soon: ')]:
            with self.subTest(options), self.assertRaisesRegex(error, words):
                sluice.open('synth:cube,dims=20x16x12', **options)

    def test_that_are_drawn_all_the_same_have_warnings(self):
        volume = sluice.from_array(ball())
        for options, words in [(dict(threshold=300), '^threshold 300: nothing shows, the values are'),
                               (dict(threshold=300), '^the picture shows nothing: '),
                               (dict(labels=True, label={222: 'red'}), '^label 222=red: no voxel has this label')]:
            with self.subTest(words), self.assertWarnsRegex(UserWarning, words):
                volume.render(size=16, **options)
        with self.assertWarnsRegex(UserWarning, 'threshold 300'):
            volume.plan(threshold=300)
        with warnings.catch_warnings():
            warnings.simplefilter('error')
            volume.render(size=16, threshold=30)
            with self.assertRaisesRegex(UserWarning, 'threshold 300'):
                volume.render(size=16, threshold=300)

    def test_that_change_nothing_have_warnings_at_the_line_of_the_caller(self):
        volume = sluice.from_array(ball())
        for options, words in [
            (dict(fov=50), '^fov changes nothing with an orthographic camera; projection perspective has'),
            (dict(mode='mip', shade=True), '^shade=True changes nothing in this mode, which is not lit$'),
            (dict(mode='mip', modulate=True), '^modulate changes nothing in this mode'),
            (dict(shade=False, ambient=0.5), '^ambient changes nothing in a picture without lighting'),
            (dict(keep_thin=True), '^keep_thin changes nothing in a picture from level 0 alone$'),
            (dict(quality='high', iso=100), '^quality changes nothing in a picture with iso$'),
            (dict(quality='high', step=3), '^quality changes nothing with a step of more than 2 voxels')]:
            for call in [volume.render, volume.plan, lambda **more: volume.probe(0.5, 0.5, **more),
                         sluice.Renderer(volume, device='cpu').render]:
                with self.subTest(words), self.assertWarnsRegex(UserWarning, words) as caught:
                    call(size=16, **options)
                self.assertEqual(caught.filename, __file__)
        with self.assertWarnsRegex(UserWarning, '^time_limit changes nothing in the plan'):
            volume.plan(time_limit=9)
        with self.assertWarnsRegex(UserWarning, '^seed changes nothing without policy random$') as caught:
            sluice.Renderer(volume, seed=3)
        self.assertEqual(caught.filename, __file__)
        with warnings.catch_warnings():
            warnings.simplefilter('error')
            volume.render(size=16, time_limit=9, keep_thin=False, modulate=False, fov=None, shade='chosen', mode='mip')
            volume.render(size=16, quality='high', step=1, fov=50, projection='perspective')
            sluice.Renderer(volume, seed=3, policy='random', merge='first-fit')

    def test_that_fail_say_what_has_to_change_in_words_of_python(self):
        volume = sluice.from_array(ball())
        for call, kind, words in [
            (lambda: sluice.open('no/such/file.nrrd'), 'input', 'no/such/file.nrrd'),
            (lambda: sluice.Renderer(volume, memory=10), 'memory', '^memory .* give memory'),
            (lambda: volume.render(map='pinkish'), 'request', 'map'),
            (lambda: volume.render(iso='5:0.4:pinkish'), 'request', '^iso 5:0.4:pinkish: there is no colour'),
            (lambda: volume.render(level=5), 'request', 'level 5'),
            (lambda: volume.save('/dev/full/picture.png'), 'input', '/dev/full')]:
            with self.subTest(words), self.assertRaisesRegex(sluice.Error, words) as caught:
                call()
            self.assertEqual(caught.exception.kind, kind)
            self.assertNotIn('--', str(caught.exception))

    def test_of_buckets_find_a_key_where_amazons_tools_do(self):
        before = dict(os.environ)
        with tempfile.TemporaryDirectory() as folder:
            home = pathlib.Path(folder)
            (home / '.aws').mkdir()
            (home / '.aws/credentials').write_text('[lab]\naws_access_key_id = A\naws_secret_access_key = B=%C\n')
            (home / '.aws/config').write_text('[profile lab]\nregion = us-west-2\n[default]\nregion = sa-east-1\n')
            try:
                for name in [name for name in os.environ if name.startswith('AWS_')]:
                    del os.environ[name]
                os.environ.update(HOME=folder)
                def key():
                    return sluice._sluice.bucket_access(os.environ.get)
                self.assertEqual(key()['region'], 'sa-east-1')
                self.assertEqual(key()['access_key'], '')
                os.environ['AWS_PROFILE'] = 'lab'
                self.assertEqual(key(), dict(access_key='A', secret_key='B=%C', session_token='',
                                                     region='us-west-2', endpoint=''))
                os.environ.update(AWS_ACCESS_KEY_ID='D', AWS_SECRET_ACCESS_KEY='E', AWS_REGION='eu-west-1')
                self.assertEqual(key(), dict(access_key='D', secret_key='E', session_token='',
                                                     region='eu-west-1', endpoint=''))
                os.environ['AWS_PROFILE'] = 'lap'
                with self.assertRaisesRegex(sluice.Error, 'no profile lap'):
                    sluice.open('s3://bucket/key')
            finally:
                os.environ.clear()
                os.environ.update(before)

    def test_take_none_as_the_default(self):
        volume = sluice.from_array(ball())
        same = {keyword: None for keyword in sluice._sluice.keywords()}
        self.assertTrue((volume.render(**{**same, 'size': 32}) == volume.render(size=32)).all())

    def test_modulate_with_the_ramp_of_the_program(self):
        volume = sluice.from_array(ball())
        plain, modulated, given, other = (
            volume.render(size=32, threshold=10, **options)
            for options in ({}, dict(modulate=True), dict(modulate=True, full_gradient=0.1),
                            dict(modulate=True, full_gradient=0.9)))
        self.assertTrue((modulated == given).all())
        self.assertFalse((modulated == plain).all())
        self.assertFalse((modulated == other).all())
        self.assertTrue((volume.render(size=32, threshold=10, modulate=False) == plain).all())

    def test_take_bytes_as_the_program_does(self):
        volume = sluice.from_array(ball())
        expected = volume.render(size=32, max_bytes=20 << 10)
        self.assertTrue((volume.render(size=32, max_bytes='20K') == expected).all())

    def test_have_every_keyword_in_the_docstring(self):
        words = set(sluice.Renderer.render.__doc__.replace(',', ' ').replace('.', ' ').split())
        self.assertLessEqual(set(sluice._sluice.keywords()), words)
        for keyword, _ in sluice._sluice.volume_keyword_types():
            self.assertIn(f'`{keyword}`', sluice.open.__doc__)

    def test_have_every_keyword_in_the_stubs(self):
        stubs = ast.parse((pathlib.Path(PACKAGE) / 'sluice/__init__.pyi').read_text())
        for name, keywords in [('PictureOptions', set(sluice._sluice.keywords()) - {'depth'}),
                               ('VolumeOptions', {keyword for keyword, _ in sluice._sluice.volume_keyword_types()})]:
            options = next(node for node in stubs.body if getattr(node, 'name', '') == name)
            self.assertEqual({field.target.id for field in options.body}, keywords)

    def test_that_are_no_volumes_or_places_are_refused_by_their_keywords(self):
        a = numpy.zeros((4, 4, 4), 'u1')
        for keyword, call in [('spacing', lambda: sluice.from_array(a, spacing=(1, 1))),
                              ('spacing', lambda: sluice.from_array(a, spacing=2)),
                              ('origin', lambda: sluice.from_array(a, origin='abc')),
                              ('unit', lambda: sluice.from_array(a, unit=3)),
                              ('path', lambda: sluice.open(3)),
                              ('volume', lambda: sluice.Renderer(a))]:
            with self.subTest(keyword), self.assertRaisesRegex((TypeError, ValueError), f'^{keyword}: expected'):
                call()

    def test_have_names_of_any_bytes_but_zero(self):
        volume = sluice.from_array(ball())
        with tempfile.TemporaryDirectory() as folder:
            for keyword, call in [('path', lambda name: volume.save(name)), ('path', sluice.open),
                                  ('path', lambda name: sluice.open([name])), ('trace', sluice.simulate),
                                  ('path', sluice.Renderer(volume).record_to),
                                  ('transfer', lambda name: volume.render(size=8, transfer=name)),
                                  ('over', lambda name: sluice.open(PHANTOM, over=name)),
                                  ('index_dir', lambda name: sluice.open(PHANTOM, index_dir=name))]:
                with self.subTest(keyword), self.assertRaisesRegex(ValueError, f'^{keyword}: expected a name without'):
                    call(f'{folder}/a\0b.png')
            self.assertEqual(os.listdir(folder), [])
            name = f'{folder}/' + os.fsdecode(b'\xff.png')
            volume.save(name, size=8)
            self.assertEqual(os.listdir(folder.encode()), [b'\xff.png'])
        with self.assertRaisesRegex(ValueError, '^path: expected a name'):
            sluice.open('')

    def test_of_masked_voxels_are_refused(self):
        a = numpy.arange(64, dtype='u1').reshape(4, 4, 4)
        with self.assertRaisesRegex(ValueError, r'array: has masked voxels.*array\.filled'):
            sluice.from_array(numpy.ma.masked_less(a, 9))
        self.assertEqual(sluice.from_array(numpy.ma.masked_less(a, 0)).value_range, (0, 63))

    def test_of_a_wrong_place_for_indices_are_refused(self):
        wrong = {'SLUICE_INDEX': ('of', 'expected off or beside'),
                 'SLUICE_INDEX_DIR': ('here', 'expected the absolute path of a folder')}
        for variable, (value, said) in wrong.items():
            with self.subTest(variable), unittest.mock.patch.dict(os.environ, {'SLUICE_INDEX': ''}):
                os.environ[variable] = value
                with self.assertRaisesRegex(ValueError, f"{variable}: {said}.*'{value}'"):
                    sluice.open('synth:shells,dims=8x8x8')
                sluice.open('synth:shells,dims=8x8x8', index_dir='')


if __name__ == '__main__':
    run_tests()
