#!/usr/bin/env python3
"""Sources of one target that are compiled in batches have no local name twice.

  check_batches.py ROOT

The presets demo, batches, asan-fast and tsan-fast compile many sources as one. What is local to a source, in
a namespace without a name, then meets what is local to the others. A namespace of the source's own around it
keeps them apart, and sources in SLUICE_APART of CMakeLists.txt are compiled by themselves. Prints each name that two sources of a target define, as
FILE:LINE: reason; exit status 1 if there is one.
"""
import pathlib
import re
import sys

TARGET = re.compile(r'\b(?:sluice_layer|sluice_test|add_library)\s*\(\s*(\w+)([^()]*)\)')
APART = re.compile(r'\bset\s*\(\s*SLUICE_APART\b([^()]*)\)')
COMMENT = re.compile(r'#.*$', re.M)
# What may open a definition at the start of a line.
TYPE = re.compile(r'(?:struct|class|enum(?: class)?|union) (\w+)[^;]*\{|using (\w+) =')
CONSTANT = re.compile(r'(?:inline |static )*const(?:expr)? .*')
CONSTANT_NAME = re.compile(r'\b(k[A-Z]\w*)(?=\s*(?:=|\{|\[))')
ENCLOSING = re.compile(r'namespace ([\w:]+) \{$')
FUNCTION = re.compile(r'(?!return\b|template\b|using\b|namespace\b|TEST|void main\b)[\w:<>,&*\s\[\]]+?[\s&*](\w+)\((.*)$')


def sources_of(cmake):
    """Target -> its .cpp files, of one CMakeLists.txt."""
    text = COMMENT.sub('', cmake.read_text())
    return {name: [cmake.parent / word for word in rest.split() if word.endswith('.cpp')]
            for name, rest in TARGET.findall(text)}


def parameters(text):
    """The types of a parameter list, which starts behind its parenthesis, as one string."""
    depth, end = 1, len(text)
    for i, c in enumerate(text):
        depth += c in '([{'
        depth -= c in ')]}'
        if depth == 0:
            end = i
            break
    types = []
    for parameter in re.split(r',(?![^<(]*[>)])', text[:end]):
        words = parameter.split('=')[0].replace('&', '& ').replace('*', '* ').split()
        types.append(' '.join(words[:-1] if len(words) > 1 else words))
    return ', '.join(types)


def local_names(path):
    """(line, namespace, name) of what a source defines in namespaces without a name, within a namespace."""
    lines = path.read_text(errors='replace').splitlines()
    found, inside, around = [], False, ''
    for number, line in enumerate(lines, 1):
        if match := ENCLOSING.match(line):
            around = match[1]
        elif line == 'namespace {':
            inside = True
        elif line.startswith('}  // namespace'):
            inside = False
        if not inside or not line or not line[0].isalpha():
            continue
        rest = ' '.join(part.strip() for part in lines[number - 1:number + 5])
        if match := TYPE.match(line):
            found.append((number, around, match[1] or match[2]))
        elif CONSTANT.match(line) and CONSTANT_NAME.search(line):
            found += [(number, around, name) for name in CONSTANT_NAME.findall(line)]
        elif match := FUNCTION.match(line):
            behind = rest[rest.index(match[1] + '(') + len(match[1]) + 1:]
            found.append((number, around, f'{match[1]}({parameters(behind)})'))
    return found


def is_same_alias(root, first, path, number):
    """An alias of one name may stand twice for one type."""
    file, line = first.rsplit(':', 1)
    text = path.read_text().splitlines()[number - 1]
    return text.startswith('using ') and (root / file).read_text().splitlines()[int(line) - 1] == text


def check(root):
    """A list of complaints about the sources under `root`."""
    apart = set()
    for words in APART.findall(COMMENT.sub('', (root / 'CMakeLists.txt').read_text())):
        apart |= set(words.split())
    complaints = []
    for top in ('src', 'io', 'cache', 'tools', 'tests'):
        for cmake in sorted((root / top).rglob('CMakeLists.txt')):
            for target, sources in sources_of(cmake).items():
                seen = {}
                for path in sources:
                    if path.stem in apart or not path.is_file():
                        continue
                    for number, around, name in local_names(path):
                        file = path.relative_to(root).as_posix()
                        first = seen.setdefault((around, name), f'{file}:{number}')
                        if not first.startswith(f'{file}:') and not is_same_alias(root, first, path, number):
                            complaints.append(f'{file}:{number}: {name} is local to {first} too, and target {target} '
                                              'is compiled in batches: share it, rename it, or give a source a namespace of its own')
    return complaints


if __name__ == '__main__':
    found = check(pathlib.Path(sys.argv[1]))
    print('\n'.join(found))
    sys.exit(1 if found else 0)
