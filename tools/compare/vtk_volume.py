"""Times VTK's volume mappers and sluice on one volume: the same views, look, size and step.

    PYTHONPATH=build/release/python xvfb-run -a /usr/bin/python3 tools/compare/vtk_volume.py FILE --threshold T

FILE is a NIfTI, NRRD or MetaImage file. Needs Debian's python3-vtk9, and xvfb for VTK's GPU mapper, which draws
with the OpenGL that is there. Each program opens the file, draws a first picture, 12 views of a turn, and one
after the threshold was raised by a fifth. Opacity is a ramp from the threshold up, the view parallel, the step a
voxel. Prints a table in seconds, and writes the pictures of the first view beside each other with --png.
"""
import argparse
import statistics
import time

import numpy
import vtk
from vtk.util import numpy_support

import sluice

VIEWS = 12
READERS = {'.nii': vtk.vtkNIFTIImageReader, '.gz': vtk.vtkNIFTIImageReader, '.nrrd': vtk.vtkNrrdReader,
           '.mha': vtk.vtkMetaImageReader, '.mhd': vtk.vtkMetaImageReader}


def timed(call):
    begin = time.perf_counter()
    result = call()
    return time.perf_counter() - begin, result


class Vtk:
    """A mapper of VTK, off screen: 'cpu' is vtkFixedPointVolumeRayCastMapper with all cores."""

    def __init__(self, kind, arguments):
        suffix = '.' + arguments.file.rsplit('.', 1)[-1]
        reader = READERS[suffix]()
        reader.SetFileName(arguments.file)
        reader.Update()
        image = reader.GetOutput()
        self.slope, self.intercept = 1.0, 0.0
        if isinstance(reader, vtk.vtkNIFTIImageReader) and reader.GetRescaleSlope():
            self.slope, self.intercept = reader.GetRescaleSlope(), reader.GetRescaleIntercept()
        self.top = image.GetScalarRange()[1]
        spacing = image.GetSpacing()
        length = min(spacing)
        if kind == 'cpu':
            mapper = vtk.vtkFixedPointVolumeRayCastMapper()
            mapper.SetImageSampleDistance(1)
            mapper.IntermixIntersectingGeometryOff()
        else:
            mapper = vtk.vtkOpenGLGPUVolumeRayCastMapper()
        mapper.SetInputData(image)
        mapper.SetAutoAdjustSampleDistances(0)
        mapper.SetSampleDistance(length)
        self.ramp = vtk.vtkPiecewiseFunction()
        colors = vtk.vtkColorTransferFunction()
        colors.AddRGBPoint(0, 0, 0, 0)
        colors.AddRGBPoint(self.top, 1, 1, 1)
        look = vtk.vtkVolumeProperty()
        look.SetColor(colors)
        look.SetScalarOpacity(self.ramp)
        look.SetScalarOpacityUnitDistance(length)
        look.SetInterpolationTypeToLinear()
        if arguments.shade:
            look.ShadeOn()
        volume = vtk.vtkVolume()
        volume.SetMapper(mapper)
        volume.SetProperty(look)
        self.renderer = vtk.vtkRenderer()
        self.renderer.AddVolume(volume)
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(arguments.size, arguments.size)
        self.window.AddRenderer(self.renderer)
        self.camera = self.renderer.GetActiveCamera()
        self.camera.ParallelProjectionOn()
        self.renderer.ResetCamera()
        extent = [(n - 1) * s for n, s in zip(image.GetDimensions(), spacing)]
        self.camera.SetParallelScale(numpy.linalg.norm(extent) / 2)
        self.angle = 0

    def draw(self, angle, threshold):
        low = (threshold - self.intercept) / self.slope
        self.ramp.RemoveAllPoints()
        self.ramp.AddPoint(low - self.top / 4096, 0)
        self.ramp.AddPoint(low, 0.01)
        self.ramp.AddPoint(self.top, 0.05)
        self.camera.Azimuth(angle - self.angle)
        self.angle = angle
        self.renderer.ResetCameraClippingRange()
        self.window.Render()
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.ReadFrontBufferOff()
        grab.Update()
        pixels = grab.GetOutput()
        width, height, _ = pixels.GetDimensions()
        return numpy_support.vtk_to_numpy(pixels.GetPointData().GetScalars()).reshape(height, width, -1)[::-1, :, :3]


class Sluice:
    def __init__(self, device, arguments):
        self.volume = sluice.open(arguments.file, index_dir='')
        self.renderer = sluice.Renderer(self.volume, device=device)
        self.options = dict(size=arguments.size, view='plain', fit='volume', step=1, map='grey',
                            range=(0, self.volume.value_range[1]), shade=arguments.shade, background='000000')

    def draw(self, angle, threshold):
        return self.renderer.render(azimuth=angle, threshold=threshold, opacity=0.05, **self.options)[:, :, :3]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('file')
    parser.add_argument('--threshold', type=float, required=True)
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--shade', action='store_true')
    parser.add_argument('--png')
    arguments = parser.parse_args()

    pictures = []
    print(f'{"":12} {"open":>8} {"first":>8} {"view":>8} {"threshold":>10}')
    for name, make in [('VTK CPU', lambda: Vtk('cpu', arguments)), ('sluice CPU', lambda: Sluice('cpu', arguments)),
                       ('VTK GL', lambda: Vtk('gpu', arguments)), ('sluice GL', lambda: Sluice('gl', arguments))]:
        opened, program = timed(make)
        first, picture = timed(lambda: program.draw(0, arguments.threshold))
        views = [timed(lambda: program.draw(360 / VIEWS * i, arguments.threshold))[0] for i in range(1, VIEWS + 1)]
        changed, _ = timed(lambda: program.draw(360, 1.2 * arguments.threshold))
        print(f'{name:12} {opened:8.3f} {first:8.3f} {statistics.median(views):8.4f} {changed:10.4f}')
        pictures.append(picture)
        del program
    if arguments.png:
        from PIL import Image
        Image.fromarray(numpy.concatenate(pictures, axis=1)).save(arguments.png)


if __name__ == '__main__':
    main()
