"""The widget for notebooks draws anew when a slider moves."""
import importlib.util
import sys
import types
import unittest

from package import ball, run_tests, sluice


class Widgets(unittest.TestCase):
    def setUp(self):
        if importlib.util.find_spec('ipywidgets') is None:
            sys.modules['ipywidgets'] = stand_in_widgets()
            self.addCleanup(sys.modules.pop, 'ipywidgets')

    def test_draw_anew_when_a_slider_moves(self):
        volume = sluice.from_array(ball(size=32))
        box = volume.widget(size=48, threshold=100, elevation=15)
        image, azimuth, elevation, threshold = box.children
        first = bytes(image.value)
        self.assertEqual(first, sluice._notebook.png(volume.render(
            size=48, threshold=100, elevation=15, fit='volume', background='000000')))
        azimuth.value = 45
        self.assertEqual(bytes(image.value), sluice._notebook.png(volume.render(
            size=48, threshold=100, azimuth=45, elevation=15, fit='volume', background='000000')))
        threshold.value = threshold.max
        self.assertNotEqual(bytes(image.value), first)
        self.assertEqual(elevation.value, 15)
        clear = volume.widget(size=48, threshold=100, background=None).children[0]
        self.assertEqual(bytes(clear.value), sluice._notebook.png(volume.render(size=48, threshold=100, fit='volume')))

    def test_have_no_slider_for_a_look_without_threshold(self):
        self.assertEqual(len(sluice.from_array(ball()).widget(size=16).children), 3)


def stand_in_widgets():
    """The part of ipywidgets that the widget uses, for machines without it."""
    class Widget:
        def __init__(self, **traits):
            self.observers = []
            self.__dict__.update(traits)

        def observe(self, call, _):
            self.observers.append(call)

        def __setattr__(self, name, value):
            self.__dict__[name] = value
            for call in self.observers if name == 'value' else []:
                call(value)

    module = types.ModuleType('ipywidgets')
    module.FloatSlider = module.Image = Widget
    module.VBox = lambda children: Widget(children=tuple(children))
    return module


if __name__ == '__main__':
    run_tests()
