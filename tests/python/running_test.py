"""Calls tell their progress, end when asked to, and give their memory back."""
import gc
import os
import pathlib
import signal
import time
import unittest

from package import PHANTOM, ball, run_tests, sluice


class Running(unittest.TestCase):
    def test_tell_progress(self):
        told = []
        volume = sluice.open(PHANTOM, progress=lambda *step: told.append(step))
        self.assertEqual(told[-1][0], 'indexing')
        self.assertEqual(told[-1][1], told[-1][2])
        stages = []
        volume.render(size=32, progress=lambda stage, done, total: stages.append(stage))
        self.assertEqual(set(stages), {'drawing'})

        def complain(*step):
            raise LookupError('enough')

        with self.assertRaisesRegex(LookupError, 'enough'):
            volume.render(size=32, progress=complain)
        self.assertEqual(volume.render(size=32).shape, (32, 32, 4))
        with self.assertRaisesRegex(TypeError, '^progress: expected a function, found 3'):
            volume.render(size=32, progress=3)

    def test_are_ended_by_a_signal_within_a_second(self):
        class Enough(Exception):
            pass

        def handler(*_):
            raise Enough

        volume = sluice.open('synth:phantom,dims=256x256x256')
        before = signal.signal(signal.SIGALRM, handler)
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.3)
            began = time.monotonic()
            with self.assertRaises(Enough):
                while True:
                    volume.render(size=2000, step=0.05)
            self.assertLess(time.monotonic() - began, 60)  # not never; how fast it is, is no test
        finally:
            signal.signal(signal.SIGALRM, before)
        self.assertEqual(volume.render(size=32).shape, (32, 32, 4))

    def test_in_a_forked_process_say_what_to_do(self):
        volume = sluice.from_array(ball())
        renderer = sluice.Renderer(volume)
        renderer.render(size=16)
        child = os.fork()
        if child == 0:
            status = 1
            try:
                renderer.render(size=16)
            except sluice.Error as error:
                status = 0 if 'fork' in str(error) else 2
            del renderer
            gc.collect()
            os._exit(status)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)
        self.assertEqual(renderer.render(size=16).shape, (16, 16, 4))

    def test_give_their_memory_back(self):
        def resident():
            gc.collect()
            return int(pathlib.Path('/proc/self/statm').read_text().split()[1]) * os.sysconf('SC_PAGE_SIZE')

        volume = sluice.from_array(ball())

        def once():
            volume.render(size=128, threshold=20)
            with self.assertRaises(ValueError):
                volume.render(zoom=-1)
            with self.assertRaises(sluice.Error):
                volume.render(size=8, map='pinkish')
            sluice.from_array(ball()).render(size=16)

        for _ in range(20):
            once()
        before = resident()
        for _ in range(200):
            once()
        self.assertLess(resident() - before, 16 << 20)


if __name__ == '__main__':
    run_tests()
