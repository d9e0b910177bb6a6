"""Checks of what the functions of the package are given; each error names the keyword.

The module _sluice checks types, too, but it answers a wrong one with a list of its signatures, which
names no keyword.
"""

import math
import operator
import os
import textwrap

from . import _sluice

_UNITS = {'K': 1 << 10, 'M': 1 << 20, 'G': 1 << 30, 'T': 1 << 40}


def byte_count(size, keyword='memory'):
    """512 or '512M' as a number of bytes; None is 0, which means the default."""
    if size is None:
        return 0
    word = size.strip().upper() if isinstance(size, str) else ''
    unit = _UNITS.get(word[-1:], 1)
    try:
        count = int(float(word[:-1] if unit > 1 else word) * unit) if isinstance(size, str) else int(size)
        is_whole = isinstance(size, str) or count == size
    except (OverflowError, TypeError, ValueError):
        count, is_whole = -1, False
    if not is_whole or not 0 < count < 1 << 63:
        raise ValueError(f"{keyword}: expected bytes as in 512000000 or '512M', found {size!r}")
    return count


# The module prints its signatures if it gets anything else, which name no keyword.
def whole(keyword, number, bits=32, least=None):
    try:
        whole = operator.index(number)
    except TypeError:
        raise TypeError(f'{keyword}: expected a whole number, found {number!r}') from None
    if abs(whole) >> bits - 1:
        raise ValueError(f'{keyword}: expected a number that {bits} bits hold, found {number!r}')
    if least is not None and whole < least:
        raise ValueError(f'{keyword}: expected a whole number from {least}, found {number!r}')
    return whole


def number(keyword, number):
    try:
        real = float(number)
    except (OverflowError, TypeError, ValueError):
        real = math.nan
    if not math.isfinite(real):
        raise TypeError(f'{keyword}: expected a number, found {number!r}')
    return real


def text(keyword, text):
    if not isinstance(text, str):
        raise TypeError(f'{keyword}: expected a text, found {text!r}')
    return text


def each_of(keyword, items, kind, item):
    """A list with item(keyword, each); a text is none, although its letters could be taken."""
    try:
        if isinstance(items, str):
            raise TypeError
        each = list(items)
    except TypeError:
        raise TypeError(f'{keyword}: expected a list of {kind}, found {items!r}') from None
    return [item(keyword, one) for one in each]


def file_name(keyword, value):
    """The bytes of a file's name, which need not be UTF-8."""
    if not isinstance(value, (str, bytes, os.PathLike)):
        raise TypeError(f'{keyword}: expected a name, found {value!r}')
    name = os.fsencode(value)
    if not name or b'\0' in name:
        raise ValueError(f'{keyword}: expected a name without zero bytes that is not empty, found {value!r}')
    return name


def three(keyword, numbers):
    """Three floats, along x, y and z."""
    try:
        x, y, z = (float(number) for number in numbers)
    except (TypeError, ValueError):
        raise ValueError(f'{keyword}: expected three numbers (x, y, z), found {numbers!r}') from None
    return x, y, z


def lists_keywords(function):
    """The function, with the keywords of pictures in the place of {keywords} in its docstring."""
    if function.__doc__:
        indent = ' ' * 8
        keywords = textwrap.fill(', '.join(_sluice.keywords()) + '.', 100, initial_indent=indent,
                                 subsequent_indent=indent)
        function.__doc__ = function.__doc__.replace(indent + '{keywords}', keywords)
    return function
