"""The guest's whole file system: busybox, drivers in load order, the test program with its libraries, `ip`, udev."""

import os
import re
import shutil
import stat
import subprocess

from debian_kernel import HilError, load_order, run

HERE = os.path.dirname(os.path.abspath(__file__))
FOLDERS = ("bin", "dev", "etc/udev/rules.d", "hil", "lib64", "lib/modules", "proc", "run", "sys", "tmp", "var", "usr/lib/udev/rules.d")
# Rules of the package udev that the tests need: modes of device nodes, names by id of serial ports.
UDEV_RULES = ("50-udev-default.rules", "60-serial.rules")
SMALL_FILES = {
    "etc/passwd": "root:x:0:0:root:/:/bin/sh\n",
    # Groups that udev's own rules and those of docs/booth.md name.
    "etc/group": "".join(f"{name}:x:{number}:\n" for number, name in enumerate(
        ("root", "tty", "dialout", "kmem", "input", "video", "render", "sgx", "audio", "lp", "disk", "cdrom", "tape", "kvm", "annulus"))),
    "etc/udev/udev.conf": "",
}


def rules_of_the_booth(document):
    """The udev rules that docs/booth.md tells the reader to install: the first block of code after their file name."""
    with open(document, encoding="utf-8") as f:
        match = re.search(r"60-annulus\.rules.*?```[a-z]*\n(.*?)```", f.read(), re.DOTALL)
    if match is None:
        raise HilError(f"read {document}: no block of rules after '60-annulus.rules': put it back, or mend rules_of_the_booth")
    return match.group(1)


def libraries(program):
    """(path as the loader looks for it, path of the file) of every shared library of a program."""
    told = run(["ldd", program], f"list the libraries of {program}", "build it first")
    missing = re.findall(r"(\S+) => not found", told)
    if missing:
        raise HilError(f"list the libraries of {program}: {', '.join(missing)} not found: install the packages of cmake/packages.txt")
    return [(path, os.path.realpath(path)) for path in re.findall(r"(/\S+) \(0x", told)]


class Initramfs:
    """Collects files in a staging folder, then packs them."""

    def __init__(self, staging):
        self.root = staging
        shutil.rmtree(staging, ignore_errors=True)
        for folder in FOLDERS:
            os.makedirs(os.path.join(staging, folder))
        for name, text in SMALL_FILES.items():
            self.write(name, text)
        self.copy("/bin/busybox", "bin/busybox")
        self.copy(os.path.join(HERE, "guest", "init.sh"), "init")
        os.chmod(os.path.join(staging, "init"), 0o755)
        for name in ("ip", "tc"):
            self.add_program(f"/sbin/{name}", f"hil/{name}")

    def write(self, name, text):
        with open(os.path.join(self.root, name), "w", encoding="utf-8") as f:
            f.write(text)

    def copy(self, source, name):
        target = os.path.join(self.root, name)
        os.makedirs(os.path.dirname(target), exist_ok=True)
        try:
            shutil.copyfile(source, target)
        except OSError as error:
            raise HilError(f"copy {source} into the guest's file system: {error}: install the packages of cmake/packages.txt") from error
        os.chmod(target, stat.S_IMODE(os.stat(source).st_mode) | 0o444)

    def add_program(self, source, name):
        """A program and its shared libraries."""
        self.copy(source, name)
        for wanted, real in libraries(source):
            if not os.path.exists(os.path.join(self.root, wanted.lstrip("/"))):
                self.copy(real, wanted.lstrip("/"))

    def add_modules(self, suite, tree, release, names):
        """The drivers of a suite and the order to load them in, as hil/<suite>.modules."""
        order = []
        for path in load_order(tree, release, names):
            name = f"lib/modules/{os.path.basename(path)}"
            order.append("/" + name)
            if not os.path.exists(os.path.join(self.root, name)):
                self.copy(path, name)
        self.write(f"hil/{suite}.modules", "".join(f"{name}\n" for name in order))

    def add_udev(self, package):
        self.add_program(os.path.join(package, "bin/udevadm"), "bin/udevadm")
        os.makedirs(os.path.join(self.root, "lib/systemd"))
        os.symlink("/bin/udevadm", os.path.join(self.root, "lib/systemd/systemd-udevd"))
        for rule in UDEV_RULES:
            self.copy(os.path.join(package, "lib/udev/rules.d", rule), f"usr/lib/udev/rules.d/{rule}")
        self.write("etc/udev/rules.d/60-annulus.rules", rules_of_the_booth(os.path.join(HERE, "../../docs/booth.md")))

    def pack(self, path):
        names = subprocess.run(["find", "."], cwd=self.root, stdout=subprocess.PIPE, check=True).stdout
        with open(path, "wb") as f:
            packed = subprocess.run(["cpio", "--quiet", "-o", "-H", "newc", "-R", "0:0"], cwd=self.root, input=names, stdout=f,
                                    stderr=subprocess.PIPE, check=False)
        if packed.returncode != 0:
            raise HilError(f"pack the guest's file system: {packed.stderr.decode(errors='replace').strip()}: install Debian's cpio")
