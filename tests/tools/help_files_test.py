"""Manual pages and completions, as man, mandoc, bash, zsh and fish take them.

  help_files_test.py PROGRAM [unittest's arguments]
"""
import os
import pathlib
import pty
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = os.path.abspath(sys.argv[1])
HOME = tempfile.TemporaryDirectory()
SHARE = pathlib.Path(HOME.name) / 'share'
subprocess.run([PROGRAM, 'help', '--files', SHARE], check=True)


def needs(program):
    return unittest.skipUnless(shutil.which(program), f'{program} is not installed')


def said(*words, **more):
    """What a command that must succeed prints on both outputs."""
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)
    if done.returncode != 0:
        raise AssertionError(f'{words}: status {done.returncode}\n{done.stdout}')
    return done.stdout


def commands():
    """The words of each command, as --help lists them."""
    found = []
    for command in re.findall(r'^  ([a-z]+)  ', said(PROGRAM), re.M):
        found.append([command])
        listed = said(PROGRAM, command, '--help').partition('Commands:\n')[2].partition('\nOptions:')[0]
        found += [[command, below] for below in re.findall(r'^  ([a-z]+) ', listed, re.M)]
    return found


def help_text(command):
    for option in ('--help-all', '--help'):
        done = subprocess.run([PROGRAM, *command, option], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        if done.returncode == 0:
            return done.stdout
    raise AssertionError(command)


def entries(text):
    """The options of a help text, each on one line: '-s, --size WxH Pixels [512x512]'."""
    found = []
    for line in text.partition('\nUsage: ')[2].splitlines():
        if re.match(r'  (    |-., )--|  [A-Z]', line):
            found.append(line)
        elif line.startswith(' ' * 30) and found:
            found[-1] += ' ' + line
    return [' '.join(entry.split()) for entry in found]


class Manual(unittest.TestCase):
    def pages(self):
        return sorted((SHARE / 'man/man1').iterdir())

    def test_has_a_page_for_each_command(self):
        expected = {'sluice.1', *('-'.join(['sluice', *command]) + '.1' for command in commands())}
        self.assertEqual({page.name for page in self.pages()}, expected)
        self.assertGreater(len(expected), 20)

    @needs('groff')
    def test_says_what_help_says(self):
        for command in commands():
            page = SHARE / 'man/man1' / ('-'.join(['sluice', *command]) + '.1')
            shown = said('groff', '-man', '-Tascii', '-P-cbou', '-rLL=400n', '-rHY=0', page)
            words = ' '.join(shown.split())
            listed = entries(help_text(command))
            self.assertTrue(listed or len(command) == 1)
            for entry in listed:
                self.assertIn(entry, words, page.name)

    @needs('groff')
    def test_is_formatted_without_a_warning(self):
        for page in self.pages():
            self.assertEqual(said('groff', '-man', '-Tutf8', '-ww', '-z', page), '', page.name)

    @needs('mandoc')
    def test_pleases_mandoc(self):
        for page in self.pages():
            self.assertEqual(said('mandoc', '-Tlint', '-Wwarning', page), '', page.name)

    @needs('man')
    def test_is_shown_by_man(self):
        env = {**os.environ, 'MANPATH': str(SHARE / 'man'), 'LC_ALL': 'C.UTF-8', 'MANWIDTH': '100', 'MANPAGER': 'cat'}
        text = said('man', '--warnings', 'sluice-bench-render', env=env)
        self.assertIn('sluice-bench-render', text)
        self.assertIn('--threshold', text)
        self.assertNotIn('warning', text)


# The words before the cursor, the last one to be completed; and what is offered.
CASES = [
    (['ren'], ['render']),
    (['bench', 'algo'], ['algorithms']),
    (['render', '--opacity-'], ['--opacity-threshold']),
    (['render', 'a.nrrd', '--mode', 'mi'], ['minip', 'mip']),
    (['render', '--mode=av'], ['average']),
    (['render', '--map', 'viri'], ['viridis']),
    (['bench', 'render', 'volume.nr'], ['volume.nrrd']),
    (['render', 'vol'], ['volume.nrrd']),
    (['synth', 'marsch'], ['marschner-lobb']),
    (['simulate', 'turn.trace', '--policies', 'lru,lir'], ['lru,lirs']),
]


class Completions(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        for name in ('volume.nrrd', 'turn.trace', 'a.nrrd'):
            (pathlib.Path(self.folder.name) / name).touch()

    def tearDown(self):
        self.folder.cleanup()

    @needs('bash')
    def test_are_offered_by_bash(self):
        script = SHARE / 'bash-completion/completions/sluice'
        for words, expected in CASES:
            split = [part for word in words for part in (re.split('(=)', word) if word.startswith('--') else [word])]
            lines = ' '.join(f"'{word}'" for word in ['sluice', *split])
            offered = said('bash', '--norc', '-c',
                           f'. {script}; COMP_WORDS=({lines}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _sluice; '
                           'printf "%s\\n" "${COMPREPLY[@]}"', cwd=self.folder.name)
            self.assertEqual(sorted(line for line in offered.split('\n')
                                    if line and 'compopt' not in line), sorted(expected), words)

    @needs('bash')
    def test_of_bash_know_every_command_and_long_option(self):
        script = SHARE / 'bash-completion/completions/sluice'
        for command in commands():
            words = ' '.join(['sluice', *command, '--'])
            offered = said('bash', '--norc', '-c',
                           f'. {script}; COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _sluice; '
                           'printf "%s\\n" "${COMPREPLY[@]}"').split()
            expected = re.findall(r'(?:^      |^  -., )(--[a-z0-9-]+)', help_text(command), re.M)
            self.assertEqual(sorted(offered), sorted(expected), command)

    @needs('fish')
    def test_are_offered_by_fish(self):
        script = SHARE / 'fish/vendor_completions.d/sluice.fish'
        env = {**os.environ, 'HOME': self.folder.name, 'XDG_CONFIG_HOME': self.folder.name, 'LC_ALL': 'C.UTF-8'}
        for words, expected in CASES:
            line = ' '.join(['sluice', *words])
            offered = said('fish', '--no-config', '-c', f"source {script}; complete -C '{line}'", cwd=self.folder.name,
                           env=env)
            found = [each.split('\t')[0] for each in offered.splitlines()]
            if '=' in words[-1]:
                found = [each.rpartition('=')[2] for each in found]
            self.assertEqual(sorted(found), sorted(expected), words)

    @needs('zsh')
    def test_are_offered_by_zsh(self):
        for words, expected in CASES:
            if len(expected) > 1:
                continue  # zsh shows a menu, which depends on the terminal
            line = ' '.join(['sluice', *words])
            completed = line[:len(line) - len(re.split('[ =]', line)[-1])] + expected[0]
            self.assertIn(completed, self.typed_into_zsh(line), words)

    def typed_into_zsh(self, line):
        """The command line after a tab."""
        folder = SHARE / 'zsh/vendor-completions'
        child, terminal = pty.fork()
        if child == 0:
            os.chdir(self.folder.name)
            os.execvpe('zsh', ['zsh', '-f', '-i'], {'PATH': os.environ['PATH'], 'HOME': self.folder.name,
                                                    'TERM': 'dumb', 'PS1': '', 'COLUMNS': '200'})
        shown = b''

        def read(until, seconds=20):
            nonlocal shown
            end = time.monotonic() + seconds
            while until not in shown and time.monotonic() < end:
                if select.select([terminal], [], [], 0.2)[0]:
                    shown += os.read(terminal, 65536)

        setup = (f'stty cols 200; PS1=; fpath=({folder} $fpath); autoload -U compinit; compinit -u -D; '
                 # Shows the line as it is, and ends.
                 "show() { print -r -- \"<$BUFFER>\"; exit }; zle -N show; bindkey '^X' show; print rea''dy\n")
        os.write(terminal, setup.encode())
        read(b'ready')
        os.write(terminal, line.encode() + b'\t\x18')
        read(b'>\r\n')
        os.close(terminal)
        os.waitpid(child, 0)
        found = re.findall(rb'<(sluice[^>]*)>', shown)
        return found[-1].decode() if found else repr(shown)


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
