#!/usr/bin/env python3
"""Runs the real program on damaged inputs of every kind that it reads.

  mutate.py PROGRAM [--count N] [--count-seed N] [--seconds 60] [--seed N] [--only KIND,...] [--keep FOLDER]

Sound files are made first (seeds.py), then each is changed where its format has its joints: fields of
a header, tags and lengths, JSON members, chunks that go missing, and bytes anywhere. After each
change the program must end by itself: status 0 or 1, never a signal; within 5 seconds of processor
time and a minute by the clock; with a peak of resident memory of at most --memory and 128 MB; with one
line on standard error where it fails, all of it printable, that names one of the files; and without a
picture that is not whole or a temporary file. What breaks a rule is printed with the file that did it,
which is kept. Each file is changed --count times, whatever time that takes; then they take turns for
--seconds (SLUICE_MUTATE_SECONDS). The same seeds make the same mutations. Exit status 1 when a rule was
broken, 77 when nothing could be tried.
"""
import argparse
import itertools
import os
import pathlib
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import mutators
import seeds

MEMORY_BYTES = 64 << 20
BESIDE_BYTES = 128 << 20
CPU_SECONDS, CLOCK_SECONDS = 5, 60
# A warning begins so; any number of them may come before the line of a failure.
WARNING = re.compile(r"^sluice: (warning|note): ")
PRINTABLE = re.compile(r"^[^\x00-\x1f\x7f]*$")


def limits():
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def names_of(folder, arguments):
    """What a message may name: a file or folder of the case, or the volume as it was given."""
    names = {p.name for p in folder.rglob("*") if "cache" not in p.parts and p.name not in ("stderr", "out.png")}
    return names | {arguments[1]} - {"."}


def litter(folder):
    """Temporary files, and pictures that are not whole."""
    found = [f"left {p.name} behind" for p in folder.rglob("*.tmp")]
    for path in folder.glob("out*.png"):
        data = path.read_bytes()
        if not (data.startswith(b"\x89PNG") and data.endswith(b"IEND\xaeB`\x82")):
            found.append(f"left half of {path.name} behind")
    return found


def run(program, arguments, folder, names):
    """(faults, status, stderr) of one run."""
    environment = dict(os.environ, XDG_CACHE_HOME=str(folder / "cache"), LP_NUM_THREADS="1", TMPDIR=str(folder))
    with open(folder / "stderr", "w+b") as err:
        process = subprocess.Popen([program] + arguments, cwd=folder, stdout=subprocess.DEVNULL, stderr=err,
                                   stdin=subprocess.DEVNULL, env=environment, preexec_fn=limits)
        deadline = time.monotonic() + CLOCK_SECONDS
        hung = False
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() > deadline:
                process.kill()
                hung = True
                deadline = float("inf")
            time.sleep(0.003)
        err.seek(0)
        text = err.read(1 << 20).decode("utf-8", "replace")
    process.returncode = 0  # waited for above
    code = os.waitstatus_to_exitcode(status)
    faults = []
    if hung:
        faults.append(f"hung for {CLOCK_SECONDS} s")
    elif code == -24 or code == -9:
        faults.append(f"took {CPU_SECONDS} s of processor time")
    elif code < 0:
        faults.append(f"ended by signal {-code}")
    elif code not in (0, 1):
        faults.append(f"status {code}")
    peak = usage.ru_maxrss << 10
    if peak > MEMORY_BYTES + BESIDE_BYTES:
        faults.append(f"took {peak >> 20} MiB, at most {(MEMORY_BYTES + BESIDE_BYTES) >> 20} are allowed")
    # Progress overwrites its line.
    lines = [line.split("\r")[-1] for line in text.split("\n") if line.strip()]
    plain = [line for line in lines if not WARNING.match(line)]
    if code == 1 and len(plain) != 1:
        faults.append(f"{len(plain)} lines on standard error")
    if "xqzpatient" in text.lower():  # whom the DICOM files of tests/io/make_dicom.py show
        faults.append("the patient is named")
    if code == 1 and not any(name in line for line in plain for name in names):
        faults.append("no file is named")
    faults += litter(folder)
    for line in lines:
        if not PRINTABLE.match(line):
            faults.append("control characters on standard error")
        if len(line) > 2000:
            faults.append(f"a line of {len(line)} characters")
    return faults, code, text


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--seconds", type=float, default=float(os.environ.get("SLUICE_MUTATE_SECONDS", "60")))
    parser.add_argument("--count", type=int, default=0)
    parser.add_argument("--count-seed", type=int, default=7)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--keep", default="mutate-failures")
    options = parser.parse_args()
    program = str(pathlib.Path(options.program).resolve())
    work = pathlib.Path(tempfile.mkdtemp(prefix="sluice-mutate-"))
    try:
        return mutate(program, work, options)
    finally:
        shutil.rmtree(work, ignore_errors=True)


def turns(cases, options):
    """The cases to change: (seed, number, case, generator)."""
    generator = random.Random(options.count_seed)
    for number in range(options.count * len(cases)):
        yield options.count_seed, number, cases[number % len(cases)], generator
    generator = random.Random(options.seed)
    until = time.monotonic() + options.seconds
    for number in itertools.count():
        if time.monotonic() >= until:
            return
        yield options.seed, number, cases[number % len(cases)], generator


def mutate(program, work, options):
    sound = work / "sound"
    sound.mkdir()
    made = seeds.make(program, sound)
    wanted = [k for k in options.only.split(",") if k]
    cases = [c for c in made if not wanted or c.kind in wanted]
    if not cases:
        print("no sound file could be made")
        return 77
    # All of them are read as they are: a mutation of a file that nobody understands proves nothing.
    unread = []
    for case in cases:
        place = work / "check"
        shutil.copytree(sound / case.name, place)
        faults, status, text = run(program, case.arguments, place, names_of(place, case.arguments))
        shutil.rmtree(place)
        if not faults and status == 1 and "which is not read without" in text:
            print(f"left out, its module was not built: {case.name}")
            unread.append(case)
            continue
        if faults or status != 0:
            print(f"{case.name}: the sound file: status {status}: {faults} {text}")
            return 1
    cases = [c for c in cases if c not in unread]
    if not cases:
        return 77
    tried, refused, broken = {}, {}, 0
    place = work / "bad"
    for seed, number, case, rng in turns(cases, options):
        shutil.copytree(sound / case.name, place)
        names = names_of(place, case.arguments)
        if case.kind == "index":  # an index is of the very files that it was made of
            run(program, case.arguments, place, names)
            (place / "out.png").unlink(missing_ok=True)
        said = mutators.apply(rng, case.kind, place)
        faults, status, text = run(program, case.arguments, place, names)
        tried[case.kind] = tried.get(case.kind, 0) + 1
        refused[case.kind] = refused.get(case.kind, 0) + (1 if status == 1 else 0)
        if faults:
            broken += 1
            kept = pathlib.Path(options.keep) / f"{seed}-{number}-{case.name}"
            shutil.rmtree(kept, ignore_errors=True)
            shutil.copytree(place, kept)
            print(f"{case.name} ({said}): {'; '.join(sorted(set(faults)))}\n  {' '.join(case.arguments)}\n"
                  f"  kept in {kept}\n  {text[:300]!r}", flush=True)
        shutil.rmtree(place)
    for kind in sorted(tried):
        print(f"{kind}: {tried[kind]} tried, {refused[kind]} refused")
    print(f"{sum(tried.values())} mutations, {broken} broke a rule")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
