#!/usr/bin/python3
"""The contract every tool keeps, tried from outside: help, usage errors, bad files, streams, signals, stats record.

    contract.py BIN TOOL        checks BIN/TOOL; needs the other tools beside it to make inputs
    contract.py BIN pipes       the pipe of three tools

Prints a line for each broken promise; status 1 if there is any, 77 if a tool it needs is not built.
"""

import json
import os
import pathlib
import pty
import re
import select
import shlex
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LIMIT = 120  # seconds after which a run counts as hung

# A small run of each tool, and one long enough to be interrupted. {volume}, {coefficients}, {image} are inputs.
SMALL = {
    "vol-phantom": "marschner-lobb --dims 17x16x15 -o out.nrrd",
    "vol-info": "{volume}",
    "vol-convert": "{volume} -o out.mha",
    "vol-compare": "{volume} {volume}",
    "vol-dwt": "{volume} -o out.vdb",
    "vol-index": "{coefficients} -o out.nrrd --epsilon 0.01",
    "vol-raycast": "{volume} -o out.exr --size 16x16",
    "img-compare": "{image} {image}",
    "vol-fft": "{volume} -o out.nrrd --pad 1.5 --compensate es:6",
    "tf-fit": "{profile} -o out.yaml --points 5",
    "fvr-slice": "{spectrum} -o out.exr --size 32x24 --view 30,20",
    "fvr-slice-gpu": "{spectrum} -o out.exr --size 32x24 --view 30,20",
    "isosurf-mc": "{volume} --isovalue 0.5 -o out.ply",
    "vol-segment": "{coefficients} -o out.nrrd --classes 3",
    "isosurf-ray": "{volume} --isovalue 0.5 -o out.exr --size 16x16",
    "wavelet-raycast": "{coefficients} -o out.exr --size 16x16",
    "curv-tricubic": "{grid} -o out.exr --size 16x16",
}
LONG = {
    "vol-phantom": "protein --dims 400x400x400 --type f64 -o out.nrrd",
    "vol-convert": "{volume} --resample 700x700x700 -o out.nrrd",
    "vol-dwt": "{big} -o out.vdb --wavelet battle-lemarie",
    "vol-raycast": "{volume} -o out.exr --size 512x512 --quadrature reference --tolerance 1e-12",
    "vol-fft": "{big} -o out.nrrd --pad 2 --shading directional",
    "fvr-slice": "{spectrum} -o out.exr --size 1024x1024 --turntable 2000",
    "fvr-slice-gpu": "{spectrum} -o out.exr --size 1024x1024 --turntable 2000",
    "isosurf-mc": "{big} --isovalue " + ",".join(f"{n / 40}" for n in range(1, 40)) + " -o out.obj",
    "isosurf-ray": "{volume} --isovalue 0.5 -o out.exr --size 4096x4096 --reconstruction catmull-rom",
    "wavelet-raycast": "{coefficients} -o out.exr --size 4096x4096",
    "curv-tricubic": "{grid} -o out.exr --size 4096x4096 --method rays",
}
READS = {  # an input of the kind the tool wants, by the placeholder above
    "vol-info": "volume", "vol-convert": "volume", "vol-compare": "volume", "vol-dwt": "volume",
    "vol-index": "coefficients", "vol-raycast": "volume", "img-compare": "image",
    "vol-fft": "volume", "tf-fit": "profile", "fvr-slice": "spectrum", "fvr-slice-gpu": "spectrum",
    "isosurf-mc": "volume", "isosurf-ray": "volume", "wavelet-raycast": "coefficients", "vol-segment": "coefficients",
    "curv-tricubic": "grid",
}
MAKE = {
    "volume": ("volume.nrrd", "vol-phantom marschner-lobb --dims 17x16x15 -o volume.nrrd"),
    "big": ("big.nrrd", "vol-phantom ramp --dims 256x256x256 --type f32 -o big.nrrd"),
    "coefficients": ("coefficients.vdb", "vol-phantom marschner-lobb --dims 17x16x15 -o - | vol-dwt - -o coefficients.vdb"),
    "spectrum": ("spectrum.nrrd", "vol-phantom marschner-lobb --dims 17x16x15 -o - | vol-fft - -o spectrum.nrrd"),
    "profile": ("profile.csv", "printf 'value,weight\\n0,0\\n50,0\\n60,1\\n80,1\\n100,0\\n' > profile.csv"),
    "grid": ("grid.vts", "vol-phantom twisted-box --dims 5x4x6 -o grid.vts"),
    "image": ("image.exr", "vol-phantom marschner-lobb --dims 17x16x15 -o - | vol-raycast - -o image.exr --size 16x16"),
}


class Contract:
    def __init__(self, bin_folder, tool):
        self.bin, self.tool = pathlib.Path(bin_folder).resolve(), tool
        self.environment = {**os.environ, "PATH": f"{self.bin}:{os.environ['PATH']}", "LC_ALL": "C.UTF-8"}
        self.broken = []

    def expect(self, promise, holds, *details):
        if not holds:
            said = " | ".join(str(detail).strip()[:300] for detail in details)
            self.broken.append(f"{self.tool}: {promise}: {said}")
        return holds

    def run(self, arguments, folder, **options):
        if isinstance(arguments, str):
            arguments = shlex.split(arguments)
        return subprocess.run([self.tool, *arguments], cwd=folder, env=self.environment, capture_output=True,
                              timeout=LIMIT, **options)

    def shell(self, command, folder):
        return subprocess.run(["bash", "-e", "-o", "pipefail", "-c", command], cwd=folder, env=self.environment,
                              capture_output=True, timeout=LIMIT)

    def make(self, kind, folder):
        name, command = MAKE[kind]
        done = self.shell(command, folder)
        if done.returncode != 0:
            sys.exit(f"cannot make an input with: {command}\n{done.stderr.decode()}")
        return name

    def small(self, folder, command=None):
        """The tool's small run, its inputs made in folder."""
        command = command or SMALL[self.tool]
        for kind in re.findall(r"\{(\w+)\}", command):
            if not (folder / MAKE[kind][0]).exists():
                self.make(kind, folder)
        return command.format(**{kind: name for kind, (name, _) in MAKE.items()})

    def refuses(self, promise, done, *mentions):
        """Status 2, nothing on standard output, one line on standard error that begins with the tool's name."""
        error = done.stderr.decode(errors="replace")
        lines = [line for line in error.splitlines() if line.strip()]
        fine = done.returncode == 2 and done.stdout == b"" and len(lines) == 1 and error.startswith(self.tool + ": ")
        fine = fine and all(mention in error for mention in mentions)
        self.expect(promise, fine, f"status {done.returncode}", f"stdout {done.stdout[:60]}", error)

    # ---- the promises ------------------------------------------------------------------------------------------

    def help_and_version(self, folder):
        done = self.run("--help", folder)
        text = done.stdout.decode()
        self.expect("--help ends with 0 and says nothing on standard error", done.returncode == 0 and not done.stderr,
                    done.returncode, done.stderr.decode())
        wide = [line for line in text.splitlines() if len(line) > 100]
        self.expect("--help fits 100 columns", not wide, *wide[:2])
        self.expect("--help has an example", "\nExample:\n" in text)
        done = self.run("--version", folder)
        self.expect("--version names tool and version",
                    done.returncode == 0 and re.match(rf"{self.tool} .*\d+\.\d+\.\d+", done.stdout.decode()), done.stdout)

    def usage(self, folder):
        self.refuses("an unknown option is refused", self.run("--no-such-option", folder))
        self.refuses("no argument at all is refused", self.run("", folder))
        small = self.small(folder)
        self.refuses("a value that is no number is refused", self.run(small + " --threads many", folder))
        self.refuses("an empty value is refused", self.run(small + " --threads ''", folder), "--threads")
        (folder / "typing.toml").write_text("thraeds = 1\n")
        self.refuses("an unknown option in --config is refused", self.run(small + " --config typing.toml", folder))
        for arguments in ("--help", "--version"):
            with open("/dev/full", "wb") as full:
                done = subprocess.run([self.tool, arguments], cwd=folder, env=self.environment, stdout=full,
                                      stderr=subprocess.PIPE, timeout=LIMIT)
            self.expect(f"{arguments} to a full disk is an error of one line",
                        done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.returncode, done.stderr)

    def small_run(self, folder):
        command = self.small(folder)
        done = self.run(command + " --quiet", folder)
        if not self.expect(f"the small run works: {command}", done.returncode == 0, done.returncode, done.stderr.decode()):
            return
        self.expect("a good run with --quiet is silent on standard error", not done.stderr, done.stderr.decode())

    def repeatable(self, folder):
        """Same input and options, same bytes; threads do not count."""
        command = self.small(folder)
        outputs = re.findall(r"-o (\S+)", command)
        for name in outputs:
            self.run(command + " --threads 1", folder)
            first = (folder / name).read_bytes()
            self.run(command + " --threads 2", folder)
            self.expect("one and two threads write the same bytes", (folder / name).read_bytes() == first, name)

    def stats(self, folder):
        import jsonschema  # Debian: python3-jsonschema

        schema = json.loads((ROOT / "configs/stats.schema.json").read_text())
        command = self.small(folder)
        done = self.run(command + " --stats stats.json --checksum", folder)
        if not self.expect("--stats FILE works", done.returncode == 0, done.stderr.decode()):
            return
        record = json.loads((folder / "stats.json").read_text())
        errors = sorted(jsonschema.Draft7Validator(schema).iter_errors(record), key=str)
        self.expect("the stats record follows configs/stats.schema.json", not errors,
                    *[f"{'/'.join(map(str, e.absolute_path))}: {e.message}" for e in errors[:3]])
        self.expect("the record names the tool and its files", record["tool"] == self.tool and
                    (record["inputs"] or self.tool == "vol-phantom") and
                    all("sha256" in file for file in record["inputs"] + record["outputs"]),
                    record["inputs"], record["outputs"])
        broken = {**record, "peak_rss_bytes": "much"}
        self.expect("the schema can fail", not jsonschema.Draft7Validator(schema).is_valid(broken))
        done = self.run(command + " --quiet --stats -", folder)
        try:
            json.loads(done.stderr)
        except ValueError:
            self.expect("--stats - writes JSON to standard error", False, done.stderr[:200])
        if self.tool == "vol-info":
            much = bytearray(b"x") * (600 << 20)  # getrusage() of a child begins with its parent's memory
            self.run(command + " --stats stats.json", folder)
            own = json.loads((folder / "stats.json").read_text())["peak_rss_bytes"]
            self.expect("peak_rss_bytes is the tool's own", own < len(much) // 2, own)
        self.stats_on_a_full_disk(command, folder)

    def stats_on_a_full_disk(self, command, folder):
        """A record that is lost is an error; the outputs, whole by then, stay."""
        name = re.search(r"-o (\S+)", command)
        whole = (folder / name.group(1)).read_bytes() if name else b""
        if name:
            (folder / name.group(1)).unlink()
        done = self.run(command + " --quiet --stats /dev/full", folder)
        error = done.stderr.decode()
        self.expect("a stats record on a full disk is an error of one line",
                    done.returncode == 2 and error.startswith(f"{self.tool}: /dev/full: ") and error.count("\n") == 1,
                    done.returncode, error)
        if name:
            self.expect("a stats record on a full disk leaves the output whole",
                        (folder / name.group(1)).read_bytes() == whole, name.group(1))
        with open("/dev/full", "wb") as full:
            done = subprocess.run([self.tool, *shlex.split(command + " --quiet --stats -")], cwd=folder,
                                  env=self.environment, stdout=subprocess.DEVNULL, stderr=full, timeout=LIMIT)
        self.expect("a stats record that standard error does not take is an error", done.returncode == 2, done.returncode)

    def bad_files(self, folder):
        kind = READS.get(self.tool)
        if not kind:
            return
        command = self.small(folder)
        name = MAKE[kind][0]
        good = (folder / name).read_bytes()
        output = re.search(r"-o (\S+)", command)
        self.refuses("a missing file is refused by name", self.run(command.replace(name, "none.xyz"), folder), "none.xyz")
        self.refuses("a folder as input is refused", self.run(command.replace(name, "."), folder))
        extension = name[name.rindex("."):]
        for promise, content in {"a truncated file": good[: len(good) * 2 // 3], "an empty file": b"",
                                 "a file of no known format": b"no volume\n" * 40}.items():
            bad = f"bad{extension}"
            (folder / bad).write_bytes(content)
            if output:
                (folder / output.group(1)).write_bytes(b"what was there before")
            self.refuses(f"{promise} is refused by name", self.run(command.replace(name, bad), folder), bad)
            if output:
                kept = (folder / output.group(1)).read_bytes() == b"what was there before"
                self.expect(f"{promise} leaves the old output alone", kept)

    def bad_outputs(self, folder):
        command = self.small(folder)
        output = re.search(r"-o (\S+)", command)
        if not output:
            return
        name = output.group(1)
        command += " --quiet"
        for place in (f"no-such-folder/{name}", f"/proc/{name}"):
            self.refuses(f"an output in {place} is refused", self.run(command.replace(f"-o {name}", f"-o {place}"), folder))
        (folder / "folder").mkdir()
        self.refuses("a folder as output is refused", self.run(command.replace(f"-o {name}", "-o folder"), folder))
        with open("/dev/full", "wb") as full:
            done = subprocess.run([self.tool, *shlex.split(command.replace(f"-o {name}", "-o -"))], cwd=folder,
                                  env=self.environment, stdout=full, stderr=subprocess.PIPE, timeout=LIMIT)
        lines = done.stderr.decode().strip().splitlines()
        self.expect("a full disk is an error of one line", done.returncode == 2 and len(lines) == 1, done.returncode,
                    done.stderr.decode())
        (folder / name).write_bytes(b"what was there before")
        self.refuses("a stats record in no-such-folder is refused",
                     self.run(f"{command} --stats no-such-folder/stats.json", folder), "no-such-folder/stats.json")
        self.expect("a stats record that cannot be written leaves the old output alone",
                    (folder / name).read_bytes() == b"what was there before")
        (folder / name).unlink()
        strays = [path.name for path in folder.iterdir() if path.name not in self.inputs(folder)]
        self.expect("failed runs leave nothing behind", not strays, strays)

    def inputs(self, folder):
        return {name for name, _ in MAKE.values()} | {"folder"}

    def interrupted(self, folder):
        if self.tool not in LONG:
            return
        command = self.small(folder, LONG[self.tool])
        for number in (signal.SIGINT, signal.SIGTERM):
            self.interrupted_by(number, command, folder)

    def interrupted_by(self, number, command, folder):
        before = set(os.listdir(folder))
        delay = 0.5
        for _ in range(6):
            process = subprocess.Popen([self.tool, *shlex.split(command)], cwd=folder, env=self.environment,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            time.sleep(delay)
            if process.poll() is None:
                process.send_signal(number)
                process.communicate(timeout=LIMIT)
                self.expect(f"a run ended by {number.name} has status {128 + number}",
                            process.returncode == 128 + number, process.returncode)
                left = set(os.listdir(folder)) - before
                # Of many views those that are finished stay, whole: nothing is lost.
                views = {name for name in left if "--turntable" in command and re.fullmatch(r"out-\d+\.exr", name)}
                self.expect("an interrupted run leaves nothing half-written", left == views, left - views)
                for name in views:
                    whole = subprocess.run(["img-compare", name, name], cwd=folder, env=self.environment,
                                           capture_output=True)
                    self.expect("a view left by an interrupted run is whole", whole.returncode == 0, name)
                    os.unlink(folder / name)
                return
            process.communicate()
            for name in set(os.listdir(folder)) - before:
                os.unlink(folder / name)
            delay /= 2
        self.expect("the long run lasts long enough to be interrupted", False, command)

    def progress(self, folder):
        """A bar on a terminal in long runs, gone at the end; none with --quiet; none without a terminal."""
        if self.tool not in LONG:
            return
        command = self.small(folder, LONG[self.tool])
        for options, shown in (("", True), (" --quiet", False)):
            for delay in (0.5, 0.2, 0.05):
                said = self.said_on_a_terminal(command + options, folder, delay)
                if said is not None:
                    self.expect(f"a bar shows on a terminal: {shown}",
                                (b"%," in said or b" s" in said) == shown and (not shown or said.endswith(b"\r\033[K")), said)
                    break
            else:
                self.expect("the long run lasts long enough to show a bar", False, command + options)

    def said_on_a_terminal(self, command, folder, delay):
        """What an interrupted run wrote to its terminal, or None if it ended of itself. The bar comes after a second
        of the clock: the run stands still for as long, so that a fast one shows it too."""
        terminal, stderr = pty.openpty()
        process = subprocess.Popen([self.tool, *shlex.split(command)], cwd=folder, env=self.environment,
                                   stdout=subprocess.DEVNULL, stderr=stderr)
        os.close(stderr)
        time.sleep(delay)
        process.send_signal(signal.SIGSTOP)
        time.sleep(1.2)
        process.send_signal(signal.SIGCONT)
        said = b""
        ready, _, _ = select.select([terminal], [], [], 0.5)  # a bar that is due is drawn at once
        if ready:
            said += self.read_terminal(terminal)
        process.send_signal(signal.SIGINT)
        process.wait(LIMIT)
        while select.select([terminal], [], [], 0)[0]:
            part = self.read_terminal(terminal)
            if not part:
                break
            said += part
        os.close(terminal)
        return said if process.returncode == 130 else None

    @staticmethod
    def read_terminal(terminal):
        try:
            return os.read(terminal, 65536)
        except OSError:  # the other end is closed
            return b""

    def example(self, folder):
        """The example of --help runs as it stands, in a folder that holds the files it names."""
        text = self.run("--help", folder).stdout.decode()
        match = re.search(r"^Example:\n((?:  .*\n)+)", text, re.M)
        if not match:
            return
        command = "\n".join(line.strip() for line in match.group(1).splitlines())
        (folder / "configs").symlink_to(ROOT / "configs")
        words = shlex.split(command.replace("\\\n", " ").replace("|", " | ").replace("\n", " ; "))
        made = {words[i + 1] for i, word in enumerate(words[:-1]) if word in ("-o", "--output", "--difference", "--stats", ">")}
        for word in words:
            kind = {".nrrd": "volume", ".vdb": "coefficients", ".exr": "image"}.get(pathlib.Path(word).suffix)
            if word in made or not kind or (folder / word).exists():
                continue
            maker = kind
            if kind == "volume" and words[max(0, words.index(word) - 1)] == "--index":
                self.make("coefficients", folder)
                done = self.shell(f"vol-index coefficients.vdb -o {word} --epsilon 0.01", folder)
                self.expect("an index for the example can be made", done.returncode == 0, done.stderr.decode())
                continue
            done = self.shell(MAKE[maker][1].replace(MAKE[maker][0], word), folder)
            self.expect("an input for the example can be made", done.returncode == 0, done.stderr.decode())
        done = self.shell(command, folder)
        self.expect(f"the example runs: {command}", done.returncode in ((0, 1) if "compare" in self.tool else (0,)),
                    done.returncode, done.stderr.decode())
        lost = [name for name in made if name != "-" and not (folder / name).exists()]
        self.expect("the example writes what it names", not lost, lost)

    def check(self):
        for promise in (self.help_and_version, self.usage, self.small_run, self.repeatable, self.stats, self.bad_files,
                        self.bad_outputs, self.interrupted, self.progress, self.example):
            with tempfile.TemporaryDirectory() as folder:
                try:
                    promise(pathlib.Path(folder))
                except subprocess.TimeoutExpired as hung:
                    self.expect(promise.__name__, False, f"still running after {LIMIT} s: {hung.cmd}")


def pipes(contract):
    """Tools pass files on through standard streams, told by their first bytes."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        commands = {
            "vol-phantom marschner-lobb -o - | vol-dwt --wavelet haar - -o - | vol-index --epsilon 0.01 - -o index.nrrd": "index.nrrd",
            "vol-phantom marschner-lobb --dims 24 -o - | vol-convert - -o - | vol-raycast - -o - --size 16x16 > a.exr": "a.exr",
            "vol-phantom ramp --dims 9 -o - | vol-dwt - -o - | vol-dwt --inverse - -o back.nrrd": "back.nrrd",
        }
        for command, result in commands.items():
            done = contract.shell(command, folder)
            contract.expect(f"the pipe works: {command}", done.returncode == 0 and (folder / result).exists(),
                            done.returncode, done.stderr.decode())
        done = contract.shell("vol-info index.nrrd", folder)
        contract.expect("vol-info reads the index", done.returncode == 0, done.stderr.decode())
        # A reader that leaves early is an ordinary end for the writer, never a crash.
        done = contract.shell("set +o pipefail; vol-phantom noise --dims 64 -o - | head -c 10 > /dev/null; echo ${PIPESTATUS[0]}", folder)
        contract.expect("a closed pipe ends a tool with 2 or a signal's status", done.stdout.strip() in (b"2", b"141"),
                        done.stdout, done.stderr)


def main():
    bin_folder, name = sys.argv[1:]
    needed = {"vol-phantom", "vol-dwt", "vol-raycast"} | ({"vol-index", "vol-convert", "vol-info"} if name == "pipes" else {name})
    missing = [tool for tool in sorted(needed) if not (pathlib.Path(bin_folder) / tool).exists()]
    if missing:
        print(f"skipped: not built: {', '.join(missing)}")
        return 77
    contract = Contract(bin_folder, name)
    if name.endswith("-gpu"):
        with tempfile.TemporaryDirectory() as folder:
            done = contract.run(contract.small(pathlib.Path(folder)), folder)
        if done.returncode == 3:
            print(f"skipped: {done.stderr.decode().strip()}")
            return 77
    if name == "pipes":
        pipes(contract)
    else:
        contract.check()
    for line in contract.broken:
        print(line)
    return 1 if contract.broken else 0


if __name__ == "__main__":
    sys.exit(main())
