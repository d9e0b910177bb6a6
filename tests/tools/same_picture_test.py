#!/usr/bin/env python3
"""The same voxels, in a file of each format by another program's writer, give the same picture to the byte, the same plan and
the same coarse level. A format whose writer is not installed is named and left out; without NumPy the test is skipped."""
import hashlib
import importlib
import json
import os
import subprocess
import sys
import tempfile
import warnings

try:
    import numpy as np
except ImportError:
    print('numpy is missing')
    sys.exit(77)
warnings.filterwarnings('ignore')

PROGRAM = sys.argv[1]
sys.path.insert(0, sys.argv[2])
DATA = sys.argv[3]  # the folder of real volumes
try:
    import sluice
except ImportError as error:
    print(f'left out, {error}: arrays that are lent')
    sluice = None
ENVIRONMENT = dict(os.environ, XDG_CACHE_HOME='cache')
SPACING = (0.5, 0.75, 1.25)  # along x, y, z
SHAPE = (44, 60, 72)  # z, y, x
# The view that each picture has by itself depends on what its format means by up.
# At this step no sample rounds otherwise where the blocks of a packed store meet in other places.
VIEW = ['--step', '0.5', '--threshold', '15000', '--size', '200x160', '--eye', '100,80,60', '--target', '17,22,27', '--up', '0,1,0']


def ball():
    """A ball of noise with a box in it, so that no axis is like another."""
    z, y, x = np.mgrid[: SHAPE[0], : SHAPE[1], : SHAPE[2]]
    far = np.sqrt(((x - 35) / 30) ** 2 + ((y - 28) / 26) ** 2 + ((z - 22) / 20) ** 2)
    values = np.clip(1.3 - far, 0, 1) * 40000 + np.random.default_rng(3).integers(0, 900, SHAPE)
    values[10:20, 15:30, 20:40] = 50000
    return values.astype('uint16')


FINE = ball()
COARSE = FINE.reshape(22, 2, 30, 2, 36, 2).mean(axis=(1, 3, 5)).round().astype('uint16')


def needs(*modules):
    def mark(write):
        write.modules = modules
        return write
    return mark


@needs()
def nrrd():
    FINE.tofile('v.raw')
    with open('v.nhdr', 'w') as file:
        file.write('NRRD0004\ntype: ushort\ndimension: 3\nsizes: 72 60 44\nspacings: 0.5 0.75 1.25\nendian: little\nencoding: raw\n'
                   'data file: v.raw\n')
    return ['v.nhdr']


@needs()
def raw():
    FINE.tofile('v_72x60x44_uint16.raw')
    return ['v_72x60x44_uint16.raw']


@needs('pydicom')
def dicom():
    from pydicom.dataset import FileDataset, FileMetaDataset
    from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid
    os.mkdir('v.dicom')
    series, study = generate_uid(), generate_uid()
    for z, plane in enumerate(FINE):
        about = FileMetaDataset()
        about.MediaStorageSOPClassUID, about.MediaStorageSOPInstanceUID = CTImageStorage, generate_uid()
        about.TransferSyntaxUID = ExplicitVRLittleEndian
        slice_ = FileDataset(f'v.dicom/{z:02}.dcm', {}, file_meta=about, preamble=bytes(128))
        slice_.is_little_endian, slice_.is_implicit_VR = True, False
        slice_.SOPClassUID, slice_.SOPInstanceUID = CTImageStorage, about.MediaStorageSOPInstanceUID
        slice_.StudyInstanceUID, slice_.SeriesInstanceUID, slice_.Modality = study, series, 'OT'
        slice_.Rows, slice_.Columns = plane.shape
        slice_.PixelSpacing = [SPACING[1], SPACING[0]]  # between rows first
        slice_.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
        slice_.ImagePositionPatient = [0, 0, z * SPACING[2]]
        slice_.InstanceNumber, slice_.SamplesPerPixel, slice_.PhotometricInterpretation = z + 1, 1, 'MONOCHROME2'
        slice_.BitsAllocated, slice_.BitsStored, slice_.HighBit, slice_.PixelRepresentation = 16, 16, 15, 0
        slice_.PixelData = plane.tobytes()
        slice_.save_as(f'v.dicom/{z:02}.dcm')
    return ['v.dicom']


@needs('nibabel')
def nifti():
    import nibabel
    nibabel.save(nibabel.Nifti1Image(FINE.T, np.diag(SPACING + (1,))), 'v.nii.gz')
    return ['v.nii.gz']


@needs('vtkmodules')
def vtk_files():
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkStructuredPoints
    from vtkmodules.vtkIOImage import vtkMetaImageWriter
    from vtkmodules.vtkIOLegacy import vtkStructuredPointsWriter
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
    image = vtkStructuredPoints()
    image.SetDimensions(*SHAPE[::-1])
    image.SetSpacing(*SPACING)
    values = numpy_to_vtk(FINE.ravel(), deep=True)
    values.SetName('density')
    image.GetPointData().SetScalars(values)
    names = []
    for name, writer in (('v.vti', vtkXMLImageDataWriter()), ('v.vtk', vtkStructuredPointsWriter()), ('v.mha', vtkMetaImageWriter())):
        writer.SetFileName(name)
        writer.SetInputData(image)
        writer.Write()
        names.append(name)
    return names


@needs('tifffile')
def ome_tiff():
    import tifffile
    tifffile.imwrite('v.ome.tif', FINE, ome=True, photometric='minisblack',
                     metadata={'axes': 'ZYX', **{f'PhysicalSize{axis}': step for axis, step in zip('XYZ', SPACING)}})
    return ['v.ome.tif']


@needs('zarr')
def ome_zarr():
    import zarr
    image = zarr.open_group('v.zarr', mode='w')
    scale, half = np.array(SPACING[::-1]), np.array([0.5] * 3)
    levels = []
    for level, values in enumerate((FINE, COARSE)):
        image.create_dataset(str(level), data=values, chunks=(16, 32, 32))
        levels.append({'path': str(level), 'coordinateTransformations': [
            {'type': 'scale', 'scale': list(scale * 2**level)},
            {'type': 'translation', 'translation': list(scale * half * level)}]})
    axes = [{'name': axis, 'type': 'space', 'unit': 'micrometer'} for axis in 'zyx']
    image.attrs['multiscales'] = [{'version': '0.4', 'axes': axes, 'datasets': levels}]
    return ['v.zarr']


@needs('zarr')
def n5():
    import numcodecs
    import zarr
    image = zarr.open_group(zarr.N5Store('v.n5'), mode='w')
    for level, values in enumerate((FINE, COARSE)):
        image.array(f's{level}', values, chunks=(16, 32, 32), compressor=numcodecs.GZip(1))
    image.attrs.update({'scales': [[1, 1, 1], [2, 2, 2]], 'pixelResolution': {'dimensions': list(SPACING), 'unit': 'um'}})
    return ['v.n5']


def letters(group, **texts):
    """Imaris keeps texts as arrays of letters."""
    for name, text in texts.items():
        group.attrs[name] = np.frombuffer(str(text).encode(), 'S1')


@needs('h5py')
def hdf5():
    import h5py
    with h5py.File('v.h5', 'w') as file:
        file.create_dataset('volume', data=FINE, chunks=(16, 32, 32), compression='gzip').attrs['element_size_um'] = SPACING[::-1]
    with h5py.File('v.ims', 'w') as file:
        ends = {}
        for axis, (count, step) in enumerate(zip(SHAPE[::-1], SPACING)):
            # The edges of the voxels: the middle of the first one lies at 0 as in the other files.
            ends |= {f'ExtMin{axis}': -step / 2, f'ExtMax{axis}': (count - 0.5) * step}
        letters(file.create_group('DataSetInfo/Image'), X=SHAPE[2], Y=SHAPE[1], Z=SHAPE[0], Unit='um', **ends)
        for level, values in enumerate((FINE, COARSE)):
            group = file.create_group(f'DataSet/ResolutionLevel {level}/TimePoint 0/Channel 0')
            group.create_dataset('Data', data=values, chunks=(4, 12, 12))
            letters(group, **{f'ImageSize{axis}': count for axis, count in zip('ZYX', values.shape)})
    return ['v.h5:/volume', 'v.ims']


@needs('h5py')
def big_data_viewer():
    import h5py
    with h5py.File('v.bdv.h5', 'w') as file:
        file['s00/resolutions'] = np.array([[1.0, 1, 1], [2, 2, 2]])
        file['s00/subdivisions'] = np.array([[18, 15, 11]] * 2, 'int32')
        for level, values in enumerate((FINE, COARSE)):
            # BigDataViewer's voxels are unsigned, whatever HDF5 is told.
            file.create_dataset(f't00000/s00/{level}/cells', data=values.view('int16'), chunks=(11, 15, 18), compression='gzip')
    affine = ' '.join(f'{SPACING[row] if row == column else 0}' for row in range(3) for column in range(4))
    with open('v.xml', 'w') as file:
        file.write(f'''<?xml version="1.0" encoding="UTF-8"?>
<SpimData version="0.2"><BasePath type="relative">.</BasePath><SequenceDescription>
<ImageLoader format="bdv.hdf5"><hdf5 type="relative">v.bdv.h5</hdf5></ImageLoader>
<ViewSetups><ViewSetup><id>0</id><name>density</name><size>{SHAPE[2]} {SHAPE[1]} {SHAPE[0]}</size></ViewSetup></ViewSetups>
<Timepoints type="range"><first>0</first><last>0</last></Timepoints></SequenceDescription>
<ViewRegistrations><ViewRegistration timepoint="0" setup="0"><ViewTransform type="affine"><affine>{affine}</affine></ViewTransform>
</ViewRegistration></ViewRegistrations></SpimData>''')
    return ['v.xml']


def zarrita_files():
    """Arrays of Zarr 3 that zarrita wrote, each with an NRRD of the same numbers that NumPy writes here: they count."""
    data = os.path.join(DATA, 'formats/zarr/zarr_v3/from_zarrita/data.zarr')
    if not os.path.isdir(data):
        print(f'left out, no {data}: Zarr 3 by zarrita')
        return {}
    with open(os.path.join(data, '3d.chunked.compressed.sharded.i2/zarr.json')) as file:
        assert json.load(file)['codecs'][0]['name'] == 'sharding_indexed'
    pairs = {}
    for name, side in (('3d.chunked.compressed.sharded.i2', 4), ('3d.contiguous.compressed.sharded.i2', 3), ('3d.chunked.i2', 3),
                       ('3d.chunked.mixed.i2.F', 3), ('3d.chunked.mixed.compressed.sharded.i2', 3)):
        file = f'count{side}.nrrd'
        with open(file, 'wb') as counted:
            counted.write(f'NRRD0004\ntype: short\ndimension: 3\nsizes: {side} {side} {side}\nendian: little\nencoding: raw\n\n'.encode())
            counted.write(np.arange(side**3, dtype='<i2').tobytes())
        pairs[os.path.join(data, name)] = file
    return pairs


@needs('zarr')
def zarr_python_3():
    """A volume of Zarr 3 by zarr-python, from its version 3 on, in files and in shards."""
    import zarr
    if int(zarr.__version__.split('.')[0]) < 3:
        print(f'left out, zarr-python is {zarr.__version__}: its Zarr 3')
        return []
    for name, shards in (('v3.zarr', None), ('v3s.zarr', (32, 64, 96))):
        image = zarr.open_group(name, mode='w', zarr_format=3)
        scale, levels = np.array(SPACING[::-1]), []
        for level, values in enumerate((FINE, COARSE)):
            image.create_array(str(level), data=values, chunks=(16, 32, 32), shards=shards)
            levels.append({'path': str(level), 'coordinateTransformations': [
                {'type': 'scale', 'scale': list(scale * 2**level)},
                {'type': 'translation', 'translation': list(scale * 0.5 * level)}]})
        axes = [{'name': axis, 'type': 'space', 'unit': 'micrometer'} for axis in 'zyx']
        image.attrs['ome'] = {'version': '0.5', 'multiscales': [{'axes': axes, 'datasets': levels}]}
    return ['v3.zarr', 'v3s.zarr']


def run(*words):
    if words[1].endswith('.raw'):
        words += ('--spacing', ','.join(map(str, SPACING)))  # its name cannot say this
    done = subprocess.run([PROGRAM, *words], capture_output=True, env=ENVIRONMENT)
    assert done.returncode == 0, (words, done.stderr.decode())
    return done.stdout


def is_read(volume):
    """Whether the module for its format was built."""
    done = subprocess.run([PROGRAM, 'info', volume], capture_output=True, text=True, env=ENVIRONMENT)
    if 'which is not read without' in done.stderr:
        print(f'left out: {done.stderr.strip()}')
    return 'which is not read without' not in done.stderr


def picture(volume, *options, view=VIEW):
    run('render', volume, '-o', 'p.png', '--force', *view, *options)
    with open('p.png', 'rb') as file:
        return hashlib.md5(file.read()).hexdigest()


def lent_picture(**options):
    """Of the array itself, lent through the Python package."""
    volume = sluice.from_array(FINE, spacing=SPACING)
    volume.save('p.png', step=0.5, threshold=15000, size=(200, 160), eye=(100, 80, 60), target=(17, 22, 27), up=(0, 1, 0), **options)
    with open('p.png', 'rb') as file:
        return hashlib.md5(file.read()).hexdigest()


def plan(volume):
    """What is drawn and moved. A packed store has no empty blocks, so that fewer are invisible and neighbours are read in other runs; and
    what a reader itself holds differs from format to format."""
    whole = json.loads(run('plan', volume, *VIEW, '--levels', 'none', '--json'))
    blocks = whole['blocks']
    return [whole['algorithms'], whole['clusters'], whole['read']['blocks'], blocks['grey'], blocks['black']]


def fail_unless_one(kind, found):
    if len({json.dumps(value, sort_keys=True) for value in found.values()}) > 1:
        sys.exit(f'{kind} differ:\n' + '\n'.join(f'{file}: {json.dumps(value)}' for file, value in found.items()))
    print(f'{kind} of', *found)


def main():
    others, packed = [], ['two.zarr', 'three.zarr', 'shards.zarr']
    for write in (nrrd, raw, nifti, vtk_files, ome_tiff, ome_zarr, zarr_python_3, n5, hdf5, big_data_viewer, dicom):
        try:
            for module in write.modules:
                importlib.import_module(module)
        except ImportError as error:
            print(f'left out, {error}: {write.__name__}')
            continue
        others += [file for file in write() if is_read(file)]
    for name, options in zip(packed, ([], ['--zarr', '3'], ['--zarr', '3', '--shard', '64,64,64'])):
        run('pack', 'v.nhdr', '-o', name, '--levels', '1', '--chunk', '32', *options)
    files = others + packed
    lent, lent_lit = ({'lent': lent_picture()}, {'lent': lent_picture(shade=True)}) if sluice else ({}, {})
    fail_unless_one('pictures', {file: picture(file, '--levels', 'none') for file in files} | lent)
    fail_unless_one('lit pictures', {file: picture(file, '--levels', 'none', '--shade') for file in files} | lent_lit)
    fail_unless_one('plans', {file: plan(file) for file in files})
    fail_unless_one('coarse levels', {file: picture(file, '--level', '1') for file in others if file in ('v.zarr', 'v3.zarr', 'v3s.zarr', 'v.n5', 'v.ims', 'v.xml')})
    for file, counted in zarrita_files().items():
        fail_unless_one('pictures', {name: picture(name, view=['--threshold', '5', '--size', '80']) for name in (file, counted)})
    # These have spreads, so that they are drawn otherwise.
    fail_unless_one('packed coarse levels', {file: picture(file, '--level', '1') for file in packed})


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    main()
